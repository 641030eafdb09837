// Row 17: a goal leads through a wall, and nobody looked at the way before. By the true joints, no part of the arm
// comes nearer than the robot file's margin.
#include "shared/kinematics.hpp"
#include "tests/faults/fault_rig.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::faults {
namespace {

using arm::FaultCode;

const JointVector kBeforeTheWall = FaultRig::posture(0.2, -0.1, -0.2, 0.8, 0.1);  // where the rig's arm stands
const JointVector kBehindTheWall = FaultRig::posture(1.2, -0.1, -0.2, 0.8, 0.1);

/// A wall across the hand's way from kBeforeTheWall, so far from the arm.
RobotConfig robot_with_wall(double room_m) {
  RobotConfig robot = shipped_robot();
  CollisionModel& model = robot.collision.model;
  model.box_count = model.pair_count = 0;
  model.half_space_count = 1;
  robot.collision.half_spaces = {"wall"};
  const Vector3 way = forward_kinematics(robot.arm.chain, kBehindTheWall).p -
                      forward_kinematics(robot.arm.chain, kBeforeTheWall).p;
  model.half_spaces[0] = {-way.normalized(), 0.0};
  model.half_spaces[0].offset_m = clearance_at(model, robot.arm.chain, kBeforeTheWall).distance_m - room_m;
  return robot;
}

class TooNear : public ::testing::Test {
 protected:
  FaultRig rig{robot_with_wall(0.06)};
  const double margin_m = rig.robot.collision.model.margin_m;

  /// Over all of the truth.
  double nearest_m() const {
    double nearest = 1.0;
    for (const TruthRow& row : rig.truth)
      nearest = std::min(nearest, clearance_at(rig.robot.collision.model, rig.robot.arm.chain, row.q_rad).distance_m);
    return nearest;
  }
  int stops() const {
    return static_cast<int>(std::ranges::count_if(rig.events, [](const arm::Event& event) {
      const auto* stop = std::get_if<arm::StopEvent>(&event);
      return stop && stop->cause.code == FaultCode::kTooNear;
    }));
  }
};

TEST_F(TooNear, StopsBeforeTheMarginAndNoSoonerThanItMust) {
  ASSERT_TRUE(rig.power_up());
  rig.send_goal(kBehindTheWall);
  rig.cycles(1000);
  EXPECT_TRUE(rig.is_still());
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
  EXPECT_GT(nearest_m(), margin_m - 1e-3);
  EXPECT_LT(nearest_m(), margin_m + 0.01);
  EXPECT_EQ(stops(), 1);
}

TEST_F(TooNear, MayDriveAwayAgain) {
  ASSERT_TRUE(rig.power_up());
  rig.send_goal(kBehindTheWall);
  rig.cycles(1000);
  rig.send_goal(kBeforeTheWall);
  EXPECT_TRUE(rig.cycle_until([this] { return (rig.q_rad() - kBeforeTheWall).norm() < 0.01; }, 1000));
}

TEST_F(TooNear, WhateverIsAskedForTheMarginHolds) {
  ASSERT_TRUE(rig.power_up());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (int goal = 0; goal < 80; ++goal) {
    JointVector q = test::random_within(rig.robot.arm.limits, random);
    if (goal % 2 == 0) q = kBehindTheWall + 0.4 * (q - kBehindTheWall);
    rig.send_goal(q, 0.5 + 0.5 * u(random));
    rig.cycles(100 + static_cast<int>(500 * u(random)));
  }
  EXPECT_GT(stops(), 10);
  EXPECT_GT(nearest_m(), margin_m - 1e-3);
}

}  // namespace
}  // namespace armsight::faults
