// The joint servo under everything at once: targets beyond the limits, reversal every cycle, wanted speeds beyond the
// limits, stops, and limits changed in flight. Whatever is asked, in every step: no limit exceeded, and the way to a
// stop free. ARMSIGHT_RANDOM_STEPS says how many steps (the long tier runs 10⁷).
#include <gtest/gtest.h>

#include <cstdlib>

#include "shared/joint_servo.hpp"
#include "tests/shared/default_arm.hpp"
#include "tests/shared/setpoint_judge.hpp"

namespace armsight {
namespace {

using namespace test;

constexpr double kPeriod_s = 0.004;
constexpr double kSlack = SetpointJudge::kSlack, kRounding_rad = SetpointJudge::kRounding_rad,
                 kSum_rad = SetpointJudge::kSum_rad;

long step_count() {
  const char* steps = std::getenv("ARMSIGHT_RANDOM_STEPS");
  return steps ? std::atol(steps) : 200000;
}

/// What may happen to one joint between two samples, in words of its own.
class Judge {
 public:
  void check(const JointLimits& force_before, const JointLimits& force, const JointSetpoint& before,
             const JointSetpoint& now, Eigen::Index i) {
    const double J = std::max(force.max_jerk_rad_s3[i], force_before.max_jerk_rad_s3[i]) * (1 + kSlack);
    const double a0 = before.acceleration_rad_s2[i], a1 = now.acceleration_rad_s2[i];
    const double v0 = before.speed_rad_s[i], v1 = now.speed_rad_s[i], q0 = before.q_rad[i], q1 = now.q_rad[i];
    ASSERT_LE(std::abs(a1 - a0), J * kPeriod_s);
    // A limit that was lowered below the present value is come back to, without a step away.
    ASSERT_LE(std::abs(a1), std::max(force.max_acceleration_rad_s2[i], std::abs(a0)) * (1 + kSlack));
    const double unavoidable = coasting(v0, a0, force.max_jerk_rad_s3[i]);
    ASSERT_LE(std::abs(v1), std::max(force.max_speed_rad_s[i], unavoidable) * (1 + kSlack));
    ASSERT_LE(q1, std::max(force.max_rad[i], q0) + kSum_rad);
    ASSERT_GE(q1, std::min(force.min_rad[i], q0) - kSum_rad);
    // The samples belong to one curve with that jerk.
    ASSERT_NEAR(v1, v0 + a0 * kPeriod_s, 0.5 * J * kPeriod_s * kPeriod_s + 1e-15);
    ASSERT_NEAR(q1, q0 + v0 * kPeriod_s + 0.5 * a0 * kPeriod_s * kPeriod_s,
                J * kPeriod_s * kPeriod_s * kPeriod_s / 6.0 + kRounding_rad);
  }

  /// Speed that ramping the acceleration away leaves, where that is more.
  static double coasting(double v, double a, double J) {
    return std::max(std::abs(v), std::abs(v + a * std::abs(a) / (2 * J)));
  }
};

class RandomCommander {
 public:
  explicit RandomCommander(const JointLimits& nominal, unsigned seed) : nominal_(nominal), random_(seed) {}
  double u() { return uniform_(random_); }

  /// One step of whatever the present mood is: it changes about every 200 steps.
  void command(JointServo& servo) {
    if (u() < 0.005) mood_ = static_cast<int>(5 * u());
    if (u() < 0.01) target_ = random_between(1.5 * nominal_.min_rad - half_, 1.5 * nominal_.max_rad + half_, random_);
    if (u() < 0.01) scale_ = 0.02 + 0.98 * u();
    if (u() < 0.02) speed_ = random_between(-2 * nominal_.max_speed_rad_s, 2 * nominal_.max_speed_rad_s, random_);
    sign_ = -sign_;
    switch (mood_) {
      case 0: servo.step_towards(target_, scale_, kPeriod_s); break;
      case 1: servo.step_towards(sign_ * target_, 1.0, kPeriod_s); break;  // reversal every cycle
      case 2: servo.step_with_speed(speed_, kPeriod_s); break;
      case 3: servo.step_with_speed(sign_ * speed_, kPeriod_s); break;
      default: u() < 0.5 ? servo.step_to_rest(kPeriod_s) : servo.step_towards(target_, scale_, kPeriod_s);
    }
  }

  JointLimits changed_limits() {
    JointLimits l = nominal_;
    const JointVector one = JointVector::Ones(5);
    const auto factor = [&] { return random_between(0.1 * one, 2.0 * one, random_); };
    l.max_speed_rad_s = l.max_speed_rad_s.cwiseProduct(factor());
    l.max_acceleration_rad_s2 = l.max_acceleration_rad_s2.cwiseProduct(factor());
    l.max_jerk_rad_s3 = l.max_jerk_rad_s3.cwiseProduct(factor());
    return l;
  }
  
 private:
  JointLimits nominal_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  JointVector half_ = JointVector::Constant(5, 0.5), target_ = JointVector::Zero(5), speed_ = JointVector::Zero(5);
  double scale_ = 1.0, sign_ = 1.0;
  int mood_ = 0;
};

void expect_step_kept(const JointLimits& force_before, const JointServo& servo, const JointSetpoint& before) {
  for (Eigen::Index i = 0; i < 5; ++i)
    ASSERT_NO_FATAL_FAILURE(Judge().check(force_before, servo.limits(), before, servo.setpoint(), i)) << "joint " << i;
}

/// Of a copy: brakes to a standstill and stays inside everything on the way.
void expect_stop_free(JointServo servo) {
  // Greatest speed / least acceleration + greatest acceleration / least jerk.
  const double most_s = 1.0 / 0.2 + 4.0 / 2.0;
  for (int k = 0; k < most_s / kPeriod_s && !servo.is_at_rest(); ++k) {
    const JointSetpoint before = servo.setpoint();
    const JointLimits force = servo.limits();
    servo.step_to_rest(kPeriod_s);
    ASSERT_NO_FATAL_FAILURE(expect_step_kept(force, servo, before));
    ASSERT_LE((servo.setpoint().q_rad - servo.limits().max_rad).maxCoeff(), kSum_rad);
    ASSERT_LE((servo.limits().min_rad - servo.setpoint().q_rad).maxCoeff(), kSum_rad);
  }
  ASSERT_TRUE(servo.is_at_rest());
}

TEST(JointServoRandom, NoLimitIsEverExceeded) {
  const JointLimits nominal = default_arm().limits;
  RandomCommander commander(nominal, 1);
  JointServo servo(nominal);
  servo.reset(joints({0.1, 0.2, -0.3, 1.0, 0.0}));
  SetpointJudge sampled(nominal, kPeriod_s);
  for (long k = 0; k < step_count(); ++k) {
    const JointSetpoint before = servo.setpoint();
    commander.command(servo);
    ASSERT_NO_FATAL_FAILURE(expect_step_kept(nominal, servo, before)) << "step " << k;
    ASSERT_LE(servo.setpoint().speed_rad_s.cwiseAbs().maxCoeff(), 0.5 * (1 + kSlack)) << "step " << k;
    ASSERT_NO_FATAL_FAILURE(sampled.take(servo.setpoint().q_rad)) << "step " << k;
    if (k % 997 != 0) continue;
    ASSERT_NO_FATAL_FAILURE(expect_stop_free(servo)) << "step " << k;
  }
}

TEST(JointServoRandom, LimitsChangedInFlightAreNeverExceededOnceInForce) {
  const JointLimits nominal = default_arm().limits;
  RandomCommander commander(nominal, 2);
  JointServo servo(nominal);
  servo.reset(joints({0.1, 0.2, -0.3, 1.0, 0.0}));
  for (long k = 0; k < step_count(); ++k) {
    if (commander.u() < 0.01) servo.set_limits(commander.changed_limits());
    const JointSetpoint before = servo.setpoint();
    const JointLimits force = servo.limits();
    commander.command(servo);
    ASSERT_NO_FATAL_FAILURE(expect_step_kept(force, servo, before)) << "step " << k;
    ASSERT_LE((servo.setpoint().q_rad - nominal.max_rad).maxCoeff(), kSum_rad) << "step " << k;
    ASSERT_LE((nominal.min_rad - servo.setpoint().q_rad).maxCoeff(), kSum_rad) << "step " << k;
    if (k % 997 != 0) continue;
    ASSERT_NO_FATAL_FAILURE(expect_stop_free(servo)) << "step " << k;
  }
}

}  // namespace
}  // namespace armsight
