// Chains of seven and eight joints use what the hand leaves free: away from limits and singular postures, the hand
// unmoved. In postures found for a goal, and in the pose servo.
#include "shared/redundancy.hpp"

#include <gtest/gtest.h>

#include "shared/inverse_kinematics.hpp"
#include "shared/pose_servo.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using namespace test;

class Redundancy : public testing::TestWithParam<int> {
 protected:
  const int n = GetParam();
  const SerialChain chain = general_chain(n, 5);
  const JointVector min = JointVector::Constant(n, -2.0), max = JointVector::Constant(n, 2.0);
  std::mt19937 random{3};

  double room(const JointVector& q) const { return std::min((q - min).minCoeff(), (max - q).minCoeff()); }
  double manipulability(const JointVector& q) const { return pose_manipulability(chain, hand_kinematics(chain, q).J); }
};

TEST_P(Redundancy, KeepsTheHandAndIsNeverLessComfortable) {
  double before = 0.0, after = 0.0;
  for (int k = 0; k < 100; ++k) {
    const JointVector q = random_between(min, max, random), better = most_comfortable(chain, q, min, max);
    EXPECT_LT(pose_error(forward_kinematics(chain, q), forward_kinematics(chain, better)).norm(), 1e-10);
    EXPECT_GE(room(better), 0.0);
    EXPECT_LE(discomfort(chain, better, min, max), discomfort(chain, q, min, max));
    before += discomfort(chain, q, min, max);
    after += discomfort(chain, better, min, max);
  }
  EXPECT_LT(after, 0.5 * before) << before << " to " << after;
}

TEST_P(Redundancy, GoalsAreMetFartherFromLimitsAndSingularPostures) {
  int near[2] = {0, 0}, singular[2] = {0, 0}, solved = 0;
  for (int k = 0; k < 100; ++k) {
    const Pose goal = forward_kinematics(chain, random_between(min, max, random));
    const JointVector seed = random_between(min, max, random);
    for (const bool seeks : {false, true}) {
      const auto found = solve_ik(chain, min, max, goal, seed, {.seeks_comfort = seeks});
      if (!found || found->orientation_error_rad > 1e-4) continue;
      EXPECT_LE(found->position_error_m, 1e-5);
      solved += seeks ? 1 : 0;
      near[seeks] += room(found->q) < 0.1 ? 1 : 0;
      singular[seeks] += manipulability(found->q) < 0.02 ? 1 : 0;
    }
  }
  EXPECT_GE(solved, 98);
  EXPECT_LT(near[1], near[0] / 2) << "of " << near[0];
  EXPECT_LE(10 * singular[1], 6 * singular[0] + 5) << "of " << singular[0];
}

TEST_P(Redundancy, ThePoseServoLeavesALimitWithTheHandAtItsGoal) {
  const JointVector speed = JointVector::Constant(n, 0.5);
  for (int k = 0; k < 20; ++k) {
    JointVector q = random_between(0.7 * min, 0.7 * max, random);
    q[k % n] = max[k % n] - 0.02;
    const Pose goal = forward_kinematics(chain, q);
    const double before = discomfort(chain, q, min, max);
    for (int i = 0; i < 1500; ++i)
      q += 0.004 * pose_servo_speeds(chain, q, goal, min, max, speed, 0.004, {});
    const Vector6 e = pose_error(goal, forward_kinematics(chain, q));
    EXPECT_LT(e.head<3>().norm(), 1e-4);
    EXPECT_LT(e.tail<3>().norm(), 1e-3);
    EXPECT_LT(discomfort(chain, q, min, max), before);
  }
}

INSTANTIATE_TEST_SUITE_P(Joints, Redundancy, testing::Values(7, 8));

TEST(RedundancyOf, SixJointsIsNone) {
  const SerialChain chain = general_chain(6, 5);
  const JointVector q = JointVector::Constant(6, 1.95), limit = JointVector::Constant(6, 2.0);
  EXPECT_EQ(most_comfortable(chain, q, -limit, limit), q);
  EXPECT_EQ(pose_manipulability(general_chain(5, 5), hand_kinematics(general_chain(5, 5), q.head(5)).J), 0.0);
}

TEST(RedundancyOf, ASingularPostureIsSeen) {
  SerialChain straight;  // stretched out, it cannot come nearer to its base at any speed
  straight.joint_count = 7;
  for (std::size_t i = 0; i < 7; ++i)
    straight.T_after[i] = dh_transform({0.0, i % 2 ? -1.5707963 : 1.5707963, 0.1, 0.0});
  const JointVector stretched = JointVector::Zero(7), limit = JointVector::Constant(7, 2.5);
  EXPECT_LT(pose_manipulability(straight, hand_kinematics(straight, stretched).J), 1e-6);
  EXPECT_NEAR(discomfort(straight, stretched, -limit, limit), 1.0, 1e-4);
}

}  // namespace
}  // namespace armsight
