// Modes of operation beside cyclic position: velocity for a joint, profile position for the hand, and homing where the
// joint stands; each led to the same goals by the same tick.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

RobotConfig with_joint_2(DriveMode mode, std::uint8_t homing = 0) {
  RobotConfig robot = nominal_robot();
  robot.drives[1].mode = mode;
  robot.drives[1].homing_method = homing;
  return robot;
}

TEST(CyclicVelocity, IsConfiguredAndLeadsTheJointToTheSameGoal) {
  ArmRig rig(with_joint_2(DriveMode::kCyclicVelocity));
  ASSERT_TRUE(rig.power_up()) << fault_text(rig.state.fault);
  EXPECT_EQ(rig.bus.drive(2).object(0x6060, 0), 9u);
  EXPECT_EQ(rig.bus.drive(2).object(0x1600, 2), 0x60FF0020u);
  EXPECT_EQ(rig.bus.drive(1).object(0x1600, 2), 0x607A0020u);
  JointVector goal(5);
  goal << 0.4, 0.2, -0.3, 0.9, 0.2;
  rig.mailboxes.goal.put(rig.joint_goal(1, goal));
  ASSERT_TRUE(rig.cycle_until(
      [&] { return rig.last<GoalEvent>() && rig.last<GoalEvent>()->state == GoalState::kArrived; }, 3000));
  EXPECT_NEAR(rig.state.q_reading_rad[1], 0.2, 2e-3);
}

TEST(CyclicVelocity, StandsWhereItIsNotLed) {
  ArmRig rig(with_joint_2(DriveMode::kCyclicVelocity));
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.cycles(20);
  EXPECT_EQ(rig.bus.drive(2).target_counts, 0) << "a velocity, not the position it stands at";
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kHold));
  const double before = rig.bus.drive(2).position_counts;
  rig.cycles(500);
  EXPECT_NEAR(rig.bus.drive(2).position_counts, before, 1.0);
}

TEST(ProfilePosition, GivesTheHandOneTargetWithTheHandshake) {
  RobotConfig robot = nominal_robot();
  robot.hand.mode = DriveMode::kProfilePosition;
  ArmRig rig(robot);
  ASSERT_TRUE(rig.power_up()) << fault_text(rig.state.fault);
  FakeDrive& hand = rig.bus.drive(6);
  EXPECT_EQ(hand.object(0x6060, 0), 1u);
  rig.cycles(20);
  const std::size_t before = hand.profile_targets.size();
  rig.mailboxes.hand.put({{7, 3}, 1.0, 500});
  rig.cycles(400);
  ASSERT_EQ(hand.profile_targets.size(), before + 1) << "the goal, not a ramp";
  EXPECT_EQ(hand.profile_targets.back(), robot.hand.closed_counts);
  EXPECT_NEAR(hand.position_counts, robot.hand.closed_counts, 1.0);
  EXPECT_EQ(hand.controlword & 0x10, 0) << "let go after the acknowledgement";
}

class Homing : public testing::TestWithParam<int> {};

TEST_P(Homing, MakesHereZeroWhenFirstEnabledAndMovesNothing) {
  ArmRig rig(with_joint_2(DriveMode::kCyclicPosition, static_cast<std::uint8_t>(GetParam())));
  rig.bus.drive(2).position_counts = 1234567.0;  // an incremental encoder: anything
  ASSERT_TRUE(rig.bring_to(Mode::kReady)) << fault_text(rig.state.fault);
  EXPECT_FALSE(rig.bus.drive(2).is_homed) << "not before power was asked for";
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kHold)) << fault_text(rig.state.fault);
  EXPECT_TRUE(rig.bus.drive(2).is_homed);
  EXPECT_EQ(rig.bus.drive(2).object(0x6098, 0), static_cast<std::uint32_t>(GetParam()));
  EXPECT_EQ(rig.bus.drive(2).object(0x6060, 0), 8u) << "back in its working mode";
  rig.cycles(300);
  EXPECT_NEAR(rig.bus.drive(2).position_counts, 0.0, 1.0);
  EXPECT_NEAR(rig.state.q_reading_rad[1], rig.robot.drives[1].zero_rad, 1e-3);
  rig.order_mode(PowerWish::kPowerOff);
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.bus.drive(2).is_homed = false;
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kHold));
  EXPECT_FALSE(rig.bus.drive(2).is_homed) << "once is enough";
}

INSTANTIATE_TEST_SUITE_P(Methods, Homing, testing::Values(35, 37));

TEST(HomingFails, WithANameWhereTheDriveNeverSaysAttained) {
  ArmRig rig(with_joint_2(DriveMode::kCyclicPosition, 37));
  rig.bus.drive(2).ends_homing = false;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 1000));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kHomingFailed);
  EXPECT_EQ(rig.state.fault.node, 2);
}

}  // namespace
}  // namespace armsight::arm::test
