// Promises of the joint servo that must hold in every step, whatever is asked: limits, stopping, landing, arriving
// together.
#include "shared/joint_servo.hpp"

#include <gtest/gtest.h>

#include <cmath>
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

  int steps_to(const JointVector& target, double speed_scale = 1.0) {
    for (int k = 1; k < 20000; ++k) {
      servo.step_towards(target, speed_scale, kDt);
      if (servo.is_at_rest() && (servo.setpoint().q_rad - target).norm() < 1e-9) return k;
    }
    return -1;
  }
};

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

/// Seven pieces in closed form: jerk up, acceleration, jerk down, cruise, and the same backwards; fewer on short ways.
double quickest_s(double way, double V, double A, double J) {
  const double ramp_s = V * J >= A * A ? V / A + A / J : 2.0 * std::sqrt(V / J);  // 0 to V
  if (way >= V * ramp_s) return way / V + ramp_s;
  if (way >= 2.0 * A * A * A / (J * J)) return A / J + std::sqrt(A * A / (J * J) + 4.0 * way / A);
  return 4.0 * std::cbrt(way / (2.0 * J));
}

TEST_F(JointServoTest, TakesTheQuickestTimeFromRestToRest) {
  const JointVector start = joints({-1.0, -1.0, -1.0, 0.5, -1.0});
  for (const double way : {1e-6, 1e-3, 0.01, 0.02, 0.05, 0.1, 0.175, 0.3, 1.0, 1.8}) {
    servo.reset(start);
    JointVector target = start;
    target[0] += way;
    const double quickest = quickest_s(way, 0.5, 2.0, 20.0), taken = steps_to(target) * kDt;
    EXPECT_GE(taken, quickest - 1e-9) << way;
    EXPECT_LE(taken, quickest + kDt + 1e-9) << way;  // the next sample
  }
}

TEST_F(JointServoTest, IsNotSlowerThanTheQuickestForASpeedAlreadyThere) {
  for (int k = 0; k < 200; ++k) servo.step_with_speed(joints({0.25, 0, 0, 0, 0}), kDt);
  JointVector target = servo.setpoint().q_rad;
  target[0] += 0.8;
  const double up_s = 2.0 * std::sqrt(0.25 / 20.0), up = 0.375 * up_s;  // to 0.5 rad/s; 2 rad/s² are not reached
  const double down_s = 0.5 / 2.0 + 2.0 / 20.0, down = 0.25 * down_s;
  EXPECT_NEAR(steps_to(target) * kDt, up_s + (0.8 - up - down) / 0.5 + down_s, kDt);
}

TEST_F(JointServoTest, FromRestJointsRunOnTheStraightLineAndArriveTogether) {
  for (int trial = 0; trial < 30; ++trial) {
    const JointVector start = random_within(limits, random), target = random_within(limits, random);
    servo.reset(start);
    for (int k = 0; k < 20000 && !(servo.is_at_rest() && k > 0); ++k) {
      servo.step_towards(target, 1.0, kDt);
      const JointVector part = (servo.setpoint().q_rad - start).cwiseQuotient(target - start);
      ASSERT_LT(part.maxCoeff() - part.minCoeff(), 1e-9);
    }
    EXPECT_EQ(servo.setpoint().q_rad, target);
  }
}

TEST_F(JointServoTest, AStopOnTheWayStaysOnTheLine) {
  const JointVector start = servo.setpoint().q_rad, target = joints({1.0, -0.5, 0.5, 2.0, -1.0});
  for (int k = 0; k < 100; ++k) servo.step_towards(target, 1.0, kDt);
  while (!servo.is_at_rest()) servo.step_to_rest(kDt);
  const JointVector part = (servo.setpoint().q_rad - start).cwiseQuotient(target - start);
  EXPECT_LT(part.maxCoeff() - part.minCoeff(), 1e-9);
  EXPECT_LT(part.maxCoeff(), 0.5);
}

TEST_F(JointServoTest, JointsArriveTogetherFromMotionWhereTheyCanWait) {
  for (int trial = 0; trial < 30; ++trial) {
    servo.reset(random_within(limits, random));
    const JointVector other = random_within(limits, random), target = random_within(limits, random);
    for (int k = 0; k < 60; ++k) servo.step_towards(other, 1.0, kDt);
    std::array<int, 5> arrival{};
    servo.step_towards(target, 1.0, kDt);
    for (int k = 1; k < 20000 && !servo.is_at_rest(); ++k) {
      servo.step_towards(target, 1.0, kDt);
      for (Eigen::Index i = 0; i < 5; ++i) {
        if (std::abs(servo.setpoint().q_rad[i] - target[i]) > 1e-9) arrival[static_cast<std::size_t>(i)] = k;
      }
    }
    const auto [first, last] = std::minmax_element(arrival.begin(), arrival.end());
    EXPECT_LE(*last - *first, 1) << "steps of 4 ms between the first and the last joint";
  }
}

TEST_F(JointServoTest, StopsWithinTheBrakingTime) {
  for (int k = 0; k < 200; ++k) servo.step_with_speed(JointVector::Constant(5, 0.4), kDt);
  int steps = 0;
  while (!servo.is_at_rest() && steps < 1000) {
    servo.step_to_rest(kDt);
    ++steps;
  }
  EXPECT_LE(steps, static_cast<int>(std::ceil((0.4 / 2.0 + 2.0 / 20.0) / kDt)));
  const JointVector q = servo.setpoint().q_rad;
  servo.step_to_rest(kDt);
  EXPECT_EQ(servo.setpoint().q_rad, q);
}

TEST_F(JointServoTest, LowerLimitsThatLeaveNoWayToStopWaitUntilTheyDo) {
  JointLimits lower = limits;
  lower.max_acceleration_rad_s2 *= 0.25;
  lower.max_speed_rad_s *= 0.5;
  while (servo.setpoint().q_rad[0] < 1.45) servo.step_with_speed(joints({0.5, 0, 0, 0, 0}), kDt);
  servo.set_limits(lower);
  servo.step_to_rest(kDt);
  EXPECT_EQ(servo.limits().max_acceleration_rad_s2[0], 2.0);  // 0.5 rad/s with 0.5 rad/s²: 0.25 rad and more
  EXPECT_EQ(servo.limits().max_acceleration_rad_s2[1], 0.5);
  int steps = 0;
  const JointVector onward = joints({0.2, 0, 0, 0, 0});
  while (servo.limits().max_acceleration_rad_s2[0] > 0.5 && ++steps < 88) servo.step_with_speed(onward, kDt);
  EXPECT_LT(steps, 88);  // (0.5 / 2 + 2 / 20) s
  EXPECT_LE(servo.setpoint().q_rad[0], limits.max_rad[0]);
}

TEST_F(JointServoTest, APositionLimitThatIsMovedInFrontOfTheArmIsComeBackTo) {
  while (servo.setpoint().q_rad[0] < 0.8) servo.step_towards(limits.max_rad, 1.0, kDt);
  JointLimits tighter = limits;
  tighter.max_rad[0] = 0.82;
  servo.set_limits(tighter);
  double highest = 0.0;
  for (int k = 0; k < 2000; ++k) highest = std::max(highest, servo.step_towards(limits.max_rad, 1.0, kDt).q_rad[0]);
  EXPECT_LT(highest, 0.8 + 0.25 * (0.5 / 2.0 + 2.0 / 20.0) + 0.01);  // no farther than a stop
  EXPECT_EQ(servo.setpoint().q_rad[0], 0.82);
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

TEST_F(JointServoTest, KnowsWhereAStopWouldLeadAndHowFarFromAnyPlace) {
  for (int k = 0; k < 40; ++k) {
    const JointVector target = random_within(limits, random), place = random_within(limits, random);
    for (int step = 0; step < 20 + 7 * k; ++step) servo.step_towards(target, 1.0, kDt);
    const JointVector end = servo.stopping_rad(1.0), farthest = servo.stopping_excursion_rad(place);
    JointServo braking = servo;
    JointVector excursion = (servo.setpoint().q_rad - place).cwiseAbs();
    while (!braking.is_at_rest())
      excursion = excursion.cwiseMax((braking.step_to_rest(kDt).q_rad - place).cwiseAbs());
    EXPECT_LT((braking.setpoint().q_rad - end).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((excursion - farthest).maxCoeff(), 1e-9);
    EXPECT_LT((farthest - excursion).maxCoeff(), 1e-3) << "sampled";
    EXPECT_EQ(servo.stopping_rad(0.0), servo.setpoint().q_rad);
  }
}

}  // namespace
}  // namespace armsight
