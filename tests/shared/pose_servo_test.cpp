// The box QP against its optimality conditions, and the pose servo's promises.
#include "shared/pose_servo.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "shared/box_qp.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using namespace test;

constexpr double kBadSpeed = std::numeric_limits<double>::quiet_NaN();

TEST(BoxQp, MeetsTheOptimalityConditions) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20000; ++trial) {
    const int n = 1 + trial % kMaxJoints;
    JointMatrix M(n, n);
    JointVector g(n), lower(n), upper(n);
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) M(i, k) = normal(random);
      g[i] = 3.0 * normal(random);
      const double a = 0.5 * normal(random), b = 0.5 * normal(random);
      lower[i] = std::min(a, b);
      upper[i] = trial % 7 == 0 && i == 0 ? lower[i] : std::max(a, b);
    }
    const JointMatrix N = M.transpose() * M + 1e-3 * JointMatrix::Identity(n, n);
    const JointVector x = solve_box_qp(N, g, lower, upper);
    const JointVector slope = N * x - g;
    for (int i = 0; i < n; ++i) {
      ASSERT_GE(x[i], lower[i]);
      ASSERT_LE(x[i], upper[i]);
      ASSERT_TRUE(x[i] <= lower[i] || slope[i] <= 1e-9) << trial;   // else the cost fell by going down
      ASSERT_TRUE(x[i] >= upper[i] || slope[i] >= -1e-9) << trial;  // else by going up
    }
  }
}

class PoseServo : public testing::Test {
 protected:
  const ArmModel arm = default_arm();
  std::mt19937 random{2};

  JointVector speeds(const JointVector& q, const Pose& goal, double dt_s = 0.004) const {
    return pose_servo_speeds(arm.chain, q, goal, arm.limits.min_rad, arm.limits.max_rad, arm.limits.max_speed_rad_s,
                             dt_s, {});
  }
};

TEST_F(PoseServo, ReachesNearbyReachablePoses) {
  int reached = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const JointVector inner_min = arm.limits.min_rad.array() + 0.3, inner_max = arm.limits.max_rad.array() - 0.3;
    const JointVector q_goal = random_between(inner_min, inner_max, random);
    JointVector q = q_goal + random_between(JointVector::Constant(5, -0.2), JointVector::Constant(5, 0.2), random);
    const Pose goal = forward_kinematics(arm.chain, q_goal);
    for (int k = 0; k < 2500; ++k) q += 0.004 * speeds(q, goal);
    const Vector6 e = pose_error(goal, forward_kinematics(arm.chain, q));
    if (e.head<3>().norm() < 1e-5 && e.tail<3>().norm() < 1e-3) ++reached;
  }
  EXPECT_GE(reached, 97);
}

TEST_F(PoseServo, KeepsSpeedsAndLimits) {
  for (int trial = 0; trial < 20000; ++trial) {
    const JointVector q = random_within(arm.limits, random);
    const Pose goal = forward_kinematics(arm.chain, random_within(arm.limits, random));
    const JointVector v = speeds(q, goal);
    for (Eigen::Index i = 0; i < 5; ++i) {
      ASSERT_LE(std::abs(v[i]), arm.limits.max_speed_rad_s[i] + 1e-12);
      ASSERT_GE(q[i] + 0.004 * v[i], arm.limits.min_rad[i] - 1e-12);
      ASSERT_LE(q[i] + 0.004 * v[i], arm.limits.max_rad[i] + 1e-12);
    }
  }
}

TEST_F(PoseServo, StaysCalmAtTheStraightArm) {
  const JointVector q = joints({0.2, 0.1, 0.3, 0.0, 0.1});
  Pose goal = forward_kinematics(arm.chain, q);
  goal.p += 0.001 * goal.p.normalized();  // outwards, which no joint can do
  EXPECT_LT(speeds(q, goal).cwiseAbs().maxCoeff(), 0.05);
}

TEST_F(PoseServo, ReturnsIntoTheLimitsFromOutside) {
  JointVector q = arm.limits.max_rad;
  q[1] += 0.1;
  const JointVector v = speeds(q, forward_kinematics(arm.chain, q));
  EXPECT_NEAR(v[1], -0.5, 1e-12);
}

TEST_F(PoseServo, StandsStillOnWhatIsNoNumber) {
  const JointVector q = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  const Pose goal = forward_kinematics(arm.chain, joints({0.4, -0.4, 0.5, 1.0, 0.2}));
  Pose spoilt = goal;
  spoilt.p.x() = kBadSpeed;
  EXPECT_GT(speeds(q, goal).norm(), 0.0);
  EXPECT_EQ(speeds(q, spoilt).norm(), 0.0);
  EXPECT_EQ(speeds(q, goal, 0.0).norm(), 0.0);
  EXPECT_EQ(speeds(JointVector::Constant(5, kBadSpeed), goal).norm(), 0.0);
}

}  // namespace
}  // namespace armsight
