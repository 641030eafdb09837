// Reachable goals are found, inside the limits, with an honest certificate; the rest is refused.
#include "shared/inverse_kinematics.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using namespace test;

struct Robot {
  SerialChain chain;
  JointVector min, max;
};

Robot default_robot() {
  const ArmModel arm = default_arm();
  return {arm.chain, arm.limits.min_rad, arm.limits.max_rad};
}

Robot general_robot(int n) {
  return {general_chain(n, 5), JointVector::Constant(n, -2.0), JointVector::Constant(n, 2.0)};
}

/// Share of random reachable poses that are met to the tolerance in orientation.
double solved_share(const Robot& robot, int goals, double orientation_tolerance_rad, const IkOptions& options) {
  std::mt19937 random(4);
  int solved = 0;
  for (int k = 0; k < goals; ++k) {
    const Pose goal = forward_kinematics(robot.chain, random_between(robot.min, robot.max, random));
    const JointVector seed = random_between(robot.min, robot.max, random);
    const auto solution = solve_ik(robot.chain, robot.min, robot.max, goal, seed, options);
    if (!solution) continue;
    EXPECT_GE((solution->q - robot.min).minCoeff(), options.limit_margin_rad - 1e-12);
    EXPECT_GE((robot.max - solution->q).minCoeff(), options.limit_margin_rad - 1e-12);
    const Vector6 e = pose_error(goal, forward_kinematics(robot.chain, solution->q));
    EXPECT_NEAR(e.head<3>().norm(), solution->position_error_m, 1e-12);
    EXPECT_NEAR(e.tail<3>().norm(), solution->orientation_error_rad, 1e-12);
    EXPECT_LE(solution->position_error_m, options.position_tolerance_m);
    if (solution->orientation_error_rad <= orientation_tolerance_rad) ++solved;
  }
  return static_cast<double>(solved) / goals;
}

TEST(InverseKinematics, SolvesReachablePosesOfTheDefaultArm) {
  EXPECT_GE(solved_share(default_robot(), 1000, 1e-4, {.limit_margin_rad = 0.0}), 0.99);
}

TEST(InverseKinematics, KeepsClearOfTheLimitsAtTheCostOfTheMarginAlone) {
  EXPECT_GE(solved_share(default_robot(), 1000, 0.02, {}), 0.99);
}

TEST(InverseKinematics, SolvesReachablePosesOfFiveToSevenJointsOfAnyShape) {
  EXPECT_GE(solved_share(general_robot(5), 300, 1e-4, {.limit_margin_rad = 0.0}), 0.99);
  EXPECT_GE(solved_share(general_robot(6), 300, 1e-4, {.limit_margin_rad = 0.0}), 0.99);
  EXPECT_GE(solved_share(general_robot(7), 300, 1e-4, {.limit_margin_rad = 0.0}), 0.99);
}

TEST(InverseKinematics, KeepsThePositionWhereTheOrientationCannotBeMet) {
  const Robot robot = default_robot();
  std::mt19937 random(6);
  for (int k = 0; k < 50; ++k) {
    const JointVector q = random_between(robot.min, robot.max, random);
    Pose goal = forward_kinematics(robot.chain, q);
    goal.R = so3_exp(20.0 * kDegree * random_vector(1.0, random).normalized()) * goal.R;
    const auto solution = solve_ik(robot.chain, robot.min, robot.max, goal, q, {.limit_margin_rad = 0.0});
    ASSERT_TRUE(solution);
    EXPECT_LE(solution->position_error_m, 1e-9);
    EXPECT_LE(solution->orientation_error_rad, 20.0 * kDegree + 1e-6);  // q itself has 20°
  }
}

TEST(InverseKinematics, StaysAtASeedThatAlreadyAnswers) {
  const Robot robot = default_robot();
  const JointVector q = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  const auto solution = solve_ik(robot.chain, robot.min, robot.max, forward_kinematics(robot.chain, q), q);
  ASSERT_TRUE(solution);
  EXPECT_LT((solution->q - q).norm(), 1e-6);
}

TEST(InverseKinematics, GivesTheSameAnswerEveryTime) {
  const Robot robot = general_robot(7);
  const Pose goal = forward_kinematics(robot.chain, JointVector::Constant(7, 0.4));
  const JointVector seed = JointVector::Constant(7, -0.3);
  const auto first = solve_ik(robot.chain, robot.min, robot.max, goal, seed);
  const auto second = solve_ik(robot.chain, robot.min, robot.max, goal, seed);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->q, second->q);
}

TEST(InverseKinematics, StaysInsideItsBudgetAndAnswersTheBestUntilThen) {
  const Robot robot = general_robot(7);
  std::mt19937 random(8);
  for (int k = 0; k < 50; ++k) {
    Pose goal = forward_kinematics(robot.chain, random_between(robot.min, robot.max, random));
    goal.p *= 1.2;  // near the reach: every start is tried
    const JointVector seed = random_between(robot.min, robot.max, random);
    const auto whole = solve_ik(robot.chain, robot.min, robot.max, goal, seed);
    const auto hasty = solve_ik(robot.chain, robot.min, robot.max, goal, seed, {.max_evaluations = 200});
    if (!hasty) continue;
    ASSERT_TRUE(whole);
    EXPECT_LE(hasty->evaluations, 210);  // a step that was begun is ended
    EXPECT_LE(whole->evaluations, IkOptions{}.max_evaluations + 10);
    EXPECT_GE(hasty->orientation_error_rad, whole->orientation_error_rad - 2e-4);
    EXPECT_LE(hasty->position_error_m, IkOptions{}.position_tolerance_m);
  }
}

TEST(InverseKinematics, RefusesWhatCannotBeReached) {
  const Robot robot = default_robot();
  const JointVector seed = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  Pose far = forward_kinematics(robot.chain, seed);
  far.p *= 0.36 / far.p.norm();
  EXPECT_FALSE(solve_ik(robot.chain, robot.min, robot.max, far, seed));
  Pose near = far;
  near.p *= 0.1 / 0.36;  // the elbow cannot fold that far
  EXPECT_FALSE(solve_ik(robot.chain, robot.min, robot.max, near, seed));
}

TEST(InverseKinematics, RefusesNonsense) {
  const Robot robot = default_robot();
  const JointVector seed = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  const Pose goal = forward_kinematics(robot.chain, seed);
  Pose spoilt = goal;
  spoilt.p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solve_ik(robot.chain, robot.min, robot.max, spoilt, seed));
  EXPECT_FALSE(solve_ik(robot.chain, robot.max, robot.min, goal, seed));
  EXPECT_FALSE(solve_ik(robot.chain, robot.min, robot.max, goal, joints({0.0, 0.0})));
}

}  // namespace
}  // namespace armsight
