// The host's way round what the controller would refuse.
#include <gtest/gtest.h>

#include "host/planned_motion.hpp"
#include "host/pose_planner.hpp"
#include "host/route.hpp"
#include "tests/host/app_robot.hpp"

namespace armsight::host {
namespace {

RobotConfig route_robot() { return load_robot(ARMSIGHT_ROBOT_YAML); }

JointVector five(double a, double b, double c, double d, double e) {
  JointVector q(5);
  q << a, b, c, d, e;
  return q;
}

bool is_free(const RobotConfig& robot, const JointVector& a, const JointVector& b) {
  return check_path(robot.collision.model, robot.arm.chain, a, b, kPlanSlack_m).is_free;
}

// Poses 2 and 3 of fig. 8.4: the stand is between them.
TEST(Route, LeadsRoundTheStandAndEveryLegIsFree) {
  const RobotConfig robot = route_robot();
  const LearnedModel model{1, {}, JointVector::Zero(5)};
  RobotConfig high = robot;  // and a stand where the demo's object stands
  high.collision.boxes = {"stand"};
  high.collision.model.box_count = 1;
  high.collision.model.boxes[0] = {{so3_exp(Vector3(0, -0.17, 0.03)), {-0.36, -0.287, -0.14}}, {0.2, 0.04, 0.04}};
  const JointVector from = five(1.16, 0.57, -1.35, 0.67, -0.16), to = five(0.67, -0.34, -0.36, 0.48, -0.28);
  ASSERT_FALSE(is_free(high, from, to));
  const std::vector<JointVector> route = find_route(high, model, from, to);
  ASSERT_EQ(route.size(), 2u);
  EXPECT_TRUE(is_free(high, from, route[0]));
  EXPECT_TRUE(is_free(high, route[0], route[1]));
  EXPECT_EQ(route[1], to);
  const PlannedMotion straight = plan_motion(high, model, from, to, 1.0);
  EXPECT_NE(straight.refusal.find("of stand"), std::string::npos) << straight.refusal;
}

TEST(Route, IsStraightWhereNothingIsInTheWay) {
  RobotConfig robot = route_robot();
  robot.collision = {};
  const JointVector from = five(1.16, 0.57, -1.35, 0.67, -0.16), to = five(0.67, -0.34, -0.36, 0.48, -0.28);
  EXPECT_EQ(find_route(robot, {1, {}, JointVector::Zero(5)}, from, to).size(), 1u);
}

TEST(PosePlanner, PlansNoLookThatTheControllerWouldRefuse) {
  PlanProblem problem;
  const ArmModel arm = test_arm();
  problem.chain = arm.chain;
  problem.min_rad = arm.limits.min_rad;
  problem.max_rad = arm.limits.max_rad;
  problem.T_C_B = test_T_C_B();
  problem.T_H_M = arm.T_H_M;
  problem.view = {1280, 720, 700, 700, 640, 360};
  problem.P = wide_prior(5);
  const std::vector<CandidateLook> all = visible_postures(problem, 400, 0.0, {});
  problem.collision = route_robot().collision.model;
  problem.collision.box_count = 1;
  problem.collision.boxes[0] = {{Matrix3::Identity(), {-0.386, -0.308, -0.116}}, Vector3::Constant(0.2)};
  const std::vector<CandidateLook> kept = visible_postures(problem, 400, 0.0, {});
  ASSERT_GT(kept.size(), 10u);
  ASSERT_TRUE(std::ranges::any_of(all, [&](const CandidateLook& c) { return is_too_near(problem, c.q_real); }));
  for (const CandidateLook& look : kept)
    EXPECT_GT(clearance_at(problem.collision, problem.chain, look.q_real).distance_m, problem.collision.margin_m);
}

}  // namespace
}  // namespace armsight::host
