// Promises of the joint servo that must hold in every step, whatever is asked: limits, stopping, landing, arriving
// together.
#include "shared/joint_servo.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using namespace test;

constexpr double kDt = 0.004;
constexpr double kBadNumber = std::numeric_limits<double>::quiet_NaN();

class JointServoTest : public testing::Test {
 protected:
  const JointLimits limits = default_arm().limits;
  JointServo servo{limits};
  std::mt19937 random{1};

  void SetUp() override { servo.reset(joints({0.1, 0.2, -0.3, 1.0, 0.0})); }

  /// Every promise about the step from `before` to now.
  void expect_limits_kept(const JointSetpoint& before, double dt_s) {
    const JointSetpoint& now = servo.setpoint();
    for (Eigen::Index i = 0; i < 5; ++i) {
      ASSERT_LE(std::abs(now.speed_rad_s[i]), limits.max_speed_rad_s[i] + 1e-12);
      ASSERT_LE(std::abs(now.acceleration_rad_s2[i]), limits.max_acceleration_rad_s2[i] * (1 + 1e-9));
      ASSERT_GE(now.q_rad[i], limits.min_rad[i]);
      ASSERT_LE(now.q_rad[i], limits.max_rad[i]);
      const double middle_speed = 0.5 * (before.speed_rad_s[i] + now.speed_rad_s[i]);
      ASSERT_NEAR(now.q_rad[i], before.q_rad[i] + middle_speed * dt_s, 1e-10);
    }
  }
  int steps_to(const JointVector& target, double speed_scale = 1.0) {
    for (int k = 1; k < 20000; ++k) {
      servo.step_towards(target, speed_scale, kDt);
      if (servo.is_at_rest() && (servo.setpoint().q_rad - target).norm() < 1e-9) return k;
    }
    return -1;
  }
};

TEST_F(JointServoTest, KeepsEveryLimitInAMillionRandomSteps) {
  std::uniform_real_distribution<double> u(0.0, 1.0);
  JointVector target = servo.setpoint().q_rad, speed = JointVector::Zero(5);
  double scale = 1.0;
  for (int k = 0; k < 1000000; ++k) {
    if (u(random) < 0.01) target = random_between(1.5 * limits.min_rad, 1.5 * limits.max_rad, random);  // also outside
    if (u(random) < 0.02) speed = random_between(-2 * limits.max_speed_rad_s, 2 * limits.max_speed_rad_s, random);
    if (u(random) < 0.005) scale = 0.05 + 0.95 * u(random);
    const JointSetpoint before = servo.setpoint();
    const int kind = (k / 400) % 4;
    if (kind == 2) servo.step_with_speed(speed, kDt);
    else if (kind == 3 && u(random) < 0.5) servo.step_to_rest(kDt);
    else servo.step_towards(target, scale, kDt);
    ASSERT_NO_FATAL_FAILURE(expect_limits_kept(before, kDt)) << k;
  }
}

TEST_F(JointServoTest, LandsExactlyAndAtRest) {
  for (int k = 0; k < 50; ++k) {
    const JointVector target = random_within(limits, random);
    ASSERT_GT(steps_to(target, k % 2 == 0 ? 1.0 : 0.3), 0);
    EXPECT_EQ(servo.setpoint().q_rad, target);
    servo.step_towards(target, 1.0, kDt);
    EXPECT_EQ(servo.setpoint().q_rad, target);
    EXPECT_TRUE(servo.is_at_rest());
  }
}

TEST_F(JointServoTest, LandsExactlyFromFullMotionAfterAReversal) {
  for (int k = 0; k < 50; ++k) {
    const JointVector first = random_within(limits, random), second = random_within(limits, random);
    for (int step = 0; step < 100 + 7 * k; ++step) servo.step_towards(first, 1.0, kDt);
    ASSERT_GT(steps_to(second), 0);
  }
}

TEST_F(JointServoTest, TakesTheTrapezoidsTime) {
  const JointVector start = servo.setpoint().q_rad;
  JointVector target = start;
  target[0] += 1.0;  // 0.5 rad/s, 2 rad/s²: 1/0.5 + 0.5/2 = 2.25 s
  EXPECT_NEAR(steps_to(target) * kDt, 2.25, 2 * kDt);
}

TEST_F(JointServoTest, JointsArriveTogether) {
  for (int trial = 0; trial < 30; ++trial) {
    servo.reset(random_within(limits, random));
    const JointVector target = random_within(limits, random);
    std::array<int, 5> arrival{};
    for (int k = 1; k < 20000 && !(servo.is_at_rest() && k > 1); ++k) {
      servo.step_towards(target, 1.0, kDt);
      for (Eigen::Index i = 0; i < 5; ++i) {
        if (std::abs(servo.setpoint().q_rad[i] - target[i]) > 1e-8) arrival[static_cast<std::size_t>(i)] = k;
      }
    }
    const auto [first, last] = std::minmax_element(arrival.begin(), arrival.end());
    EXPECT_LE(*last - *first, 4) << "steps of 4 ms between the first and the last joint";
  }
}

TEST_F(JointServoTest, StopsWithinTheBrakingTime) {
  for (int k = 0; k < 100; ++k) servo.step_with_speed(JointVector::Constant(5, 0.4), kDt);
  int steps = 0;
  while (!servo.is_at_rest() && steps < 1000) {
    servo.step_to_rest(kDt);
    ++steps;
  }
  EXPECT_LE(steps, static_cast<int>(std::ceil(0.5 / 2.0 / kDt)));
  const JointVector q = servo.setpoint().q_rad;
  servo.step_to_rest(kDt);
  EXPECT_EQ(servo.setpoint().q_rad, q);
}

TEST_F(JointServoTest, FullSpeedAgainstALimitEndsAtTheLimitAtRest) {
  for (int k = 0; k < 5000; ++k) servo.step_with_speed(limits.max_speed_rad_s, kDt);
  EXPECT_LT((servo.setpoint().q_rad - limits.max_rad).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(servo.setpoint().speed_rad_s.cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(JointServoTest, ComesBackFromOutsideTheLimitsWithoutAJump) {
  JointVector q = limits.max_rad;
  q[1] += 0.05;
  servo.reset(q);
  for (int k = 0; k < 2000; ++k) {
    const double before = servo.setpoint().q_rad[1];
    servo.step_towards(limits.max_rad, 1.0, kDt);
    ASSERT_LE(servo.setpoint().q_rad[1], before);
    ASSERT_GE(servo.setpoint().q_rad[1], before - 0.5 * kDt - 1e-12);
  }
  EXPECT_EQ(servo.setpoint().q_rad, limits.max_rad);
}

TEST_F(JointServoTest, BrakesOnWhatIsNoNumber) {
  for (int k = 0; k < 100; ++k) servo.step_with_speed(JointVector::Constant(5, 0.2), kDt);
  const auto expect_braking = [&](auto&& step) {
    const JointSetpoint before = servo.setpoint();
    step();
    EXPECT_TRUE(servo.setpoint().q_rad.allFinite());
    EXPECT_LT(servo.setpoint().speed_rad_s[0], before.speed_rad_s[0]);
  };
  expect_braking([&] { servo.step_towards(JointVector::Constant(5, kBadNumber), 1.0, kDt); });
  expect_braking([&] { servo.step_towards(JointVector::Zero(5), kBadNumber, kDt); });
  expect_braking([&] { servo.step_towards(JointVector::Zero(5), 0.0, kDt); });
  expect_braking([&] { servo.step_towards(JointVector::Zero(4), 1.0, kDt); });
  expect_braking([&] { servo.step_with_speed(JointVector::Constant(5, kBadNumber), kDt); });
  const JointVector q = servo.setpoint().q_rad;
  servo.step_to_rest(kBadNumber);
  servo.step_to_rest(0.0);
  EXPECT_EQ(servo.setpoint().q_rad, q);
}

}  // namespace
}  // namespace armsight
