// A way that comes nearer than the robot file's margin is refused with pair and place before it starts, and a stop by
// distance is told with the robot file's names. That no plan's oversight gets through: tests/faults, row 17.
#include <gtest/gtest.h>

#include "arm_controller/link_reports.hpp"
#include "tests/arm_controller/link_rig.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::arm::test {
namespace {

using armsight::test::joints;

/// The rig's arm with a wall: a half-space that leaves `room_m` beside where it stands now, on the side it turns to.
RobotConfig robot_with_wall(const JointVector& q, const Vector3& normal, double room_m) {
  RobotConfig robot = nominal_robot();
  CollisionModel& model = robot.collision.model;
  model.box_count = 0;
  robot.collision.boxes.clear();
  model.half_space_count = 1;
  model.half_spaces[0] = {normal, 0.0};
  robot.collision.half_spaces = {"wall"};
  model.half_spaces[0].offset_m = clearance_at(model, robot.arm.chain, q).distance_m - room_m;
  return robot;
}

const JointVector kRigStart = joints({0.2, -0.1, -0.2, 0.8, 0.1});
const JointVector kThroughTheWall = joints({1.2, -0.1, -0.2, 0.8, 0.1});

/// Of the hand's tip when joint 1 turns on.
Vector3 way_of_hand(const RobotConfig& robot) {
  const Pose from = forward_kinematics(robot.arm.chain, kRigStart),
             to = forward_kinematics(robot.arm.chain, kThroughTheWall);
  return (to.p - from.p).normalized();
}

RobotConfig walled_robot() {
  RobotConfig nominal = nominal_robot();
  nominal.collision.model.pair_count = 0;
  return robot_with_wall(kRigStart, -way_of_hand(nominal), 0.15);
}

TEST(TooNear, AGoalIsRefusedWithThePairAndThePlace) {
  const RobotConfig walled = walled_robot();
  ArmSnapshot state;
  state.q_reading_rad = state.q_command_rad = kRigStart;
  state.model = {0, walled.camera_hint_T_C_B, JointVector::Zero(5)};
  wire::JointGoal in;
  armsight::to_wire(kThroughTheWall, in.mutable_q_real_rad());
  in.set_speed_scale(1.0);
  Goal out;
  const auto refused = read_order(in, LinkView{walled, state}, out);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->reason, wire::REFUSAL_REASON_TOO_NEAR);
  for (const char* part : {"hand comes within", "of wall", "% of it", "joints ("})
    EXPECT_NE(refused->text.find(part), std::string::npos) << refused->text;
  const JointVector back = joints({-0.5, -0.1, -0.2, 0.8, 0.1});
  in.clear_q_real_rad();
  armsight::to_wire(back, in.mutable_q_real_rad());
  EXPECT_FALSE(read_order(in, LinkView{walled, state}, out));
}

TEST(TooNear, AStopIsToldWithNames) {
  const RobotConfig walled = walled_robot();
  Clearance nearest;
  nearest.distance_m = 0.004;
  nearest.capsule = 2;
  nearest.obstacle = Obstacle::kHalfSpace;
  const Fault cause = too_near_fault(nearest, walled.collision.model.margin_m);
  wire::StopReport report;
  to_wire(StopEvent{cause, {}}, walled.collision, report);
  EXPECT_NE(report.text().find("hand comes within 4.0 mm of wall (margin 5.0 mm)"), std::string::npos) << report.text();
  EXPECT_EQ(report.side(), "self");
  EXPECT_NE(fault_text(cause).find("capsule 3 to half-space 1, 4"), std::string::npos) << fault_text(cause);
}

}  // namespace
}  // namespace armsight::arm::test
