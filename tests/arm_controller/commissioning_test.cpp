// What an arm may do before somebody has tried its joints, and the stop that their drives make by themselves.
#include <gtest/gtest.h>

#include "shared/geometry.hpp"
#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

constexpr int kElbow = 3;

RobotConfig new_robot() {
  RobotConfig robot = nominal_robot();
  robot.drives[kElbow].is_commissioned = false;
  robot.drives[kElbow].zero_rad = 3.0;  // nobody knows better: it reads far beyond its limits
  return robot;
}

class NewArm : public testing::Test {
 protected:
  /// The elbow alone, from where it stood when power came on.
  Goal elbow_goal(double from_start_rad) {
    Goal goal = rig.joint_goal(++goals_, JointVector::Constant(5, 99.0));  // the others' angles do not count
    goal.commission_joint = kElbow;
    goal.q_real_rad[kElbow] = start_rad_ + from_start_rad;
    return goal;
  }
  Answer ask(const Goal& goal) {
    rig.mailboxes.goal.put(goal);
    rig.cycle();
    return rig.last_answer();
  }
  void SetUp() override {
    ASSERT_TRUE(rig.power_up()) << fault_text(rig.state.fault);
    rig.cycles(60);
    start_rad_ = rig.state.q_command_rad[kElbow];
    ASSERT_GT(start_rad_, 3.0);
  }
  bool settles() { return rig.bring_to(Mode::kHold, 1500); }

  ArmRig rig{new_robot()};
  double start_rad_ = 0.0;
  std::uint64_t goals_ = 0;
};

TEST_F(NewArm, TakesNoGoalButOfAJointThatIsNotCommissioned) {
  EXPECT_EQ(ask(rig.joint_goal(1, rig.q_reading())), Answer::kNotCommissioned);
  Goal shoulder = elbow_goal(0.0);
  shoulder.commission_joint = 0;
  EXPECT_EQ(ask(shoulder), Answer::kWrongState);
  EXPECT_EQ(rig.state.mode, Mode::kHold);
  EXPECT_EQ(ask(elbow_goal(2.0 * kDegree)), Answer::kAccepted);
}

TEST_F(NewArm, TurnsOneJointSlowlyWithinTwoDegreesAndNoOther) {
  const JointVector before = rig.state.q_command_rad;
  ASSERT_EQ(ask(elbow_goal(2.0 * kDegree)), Answer::kAccepted);
  EXPECT_EQ(ask(elbow_goal(-2.0 * kDegree)), Answer::kMoving) << "one motion at a time";
  double last = rig.state.q_command_rad[kElbow], fastest = 0.0;
  while (rig.state.mode == Mode::kServo) {
    rig.cycle();
    fastest = std::max(fastest, std::abs(rig.state.q_command_rad[kElbow] - last) / rig.robot.controller.period_s);
    last = rig.state.q_command_rad[kElbow];
  }
  ASSERT_EQ(rig.state.mode, Mode::kHold);
  EXPECT_NEAR(rig.q_reading()[kElbow], start_rad_ + 2.0 * kDegree, 0.004);
  EXPECT_LT(fastest, 0.036);
  JointVector moved = rig.state.q_command_rad - before;
  moved[kElbow] = 0.0;
  EXPECT_LT(moved.cwiseAbs().maxCoeff(), 0.002);
  EXPECT_EQ(ask(elbow_goal(-2.0 * kDegree)), Answer::kAccepted);
  ASSERT_TRUE(settles());
  EXPECT_EQ(ask(elbow_goal(-2.2 * kDegree)), Answer::kOutOfLimits);
  EXPECT_EQ(ask(elbow_goal(2.2 * kDegree)), Answer::kOutOfLimits);
}

TEST_F(NewArm, AQuickStopIsTheDrivesOwnAtOnceAndTheyHold) {
  ASSERT_EQ(ask(elbow_goal(2.0 * kDegree)), Answer::kAccepted);
  rig.cycles(100);
  ASSERT_EQ(rig.state.mode, Mode::kServo);
  rig.mailboxes.mode.put({{7, 1}, PowerWish::kPowerOff, false, true});
  rig.cycles(2);
  for (int node = 1; node <= 5; ++node) EXPECT_EQ(rig.bus.drive(node).controlword & 0x0F, 0x02) << "node " << node;
  ASSERT_TRUE(rig.bring_to(Mode::kReady, 100));
  rig.cycles(200);
  EXPECT_EQ(rig.state.mode, Mode::kReady) << "power comes by command alone";
  EXPECT_EQ(rig.bus.drive(4).state, DriveState::kQuickStopActive);
  rig.order_mode(PowerWish::kHold);
  EXPECT_TRUE(rig.bring_to(Mode::kHold, 1000));
}

TEST(CommissionedArm, RefusesACommissioningGoalAndAnUnpoweringUnderWay) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  Goal goal = rig.joint_goal(1, rig.q_reading());
  goal.commission_joint = 1;
  rig.mailboxes.goal.put(goal);
  rig.cycle();
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
  rig.mailboxes.goal.put(rig.joint_goal(2, rig.q_reading() + JointVector::Constant(5, 0.3)));
  rig.cycles(50);
  rig.order_mode(PowerWish::kPowerOff);
  rig.cycle();
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState) << "without the word quick_stop the arm would drop";
}

TEST(Stiffness, GoesToTheDriveThatTakesItAtAPace) {
  RobotConfig robot = nominal_robot();
  robot.drives[kElbow].stiffness_object = ObjectAddress{0x20F0, 2};
  robot.drives[kElbow].stiffness_permille = 700;
  ArmRig rig(robot);
  ASSERT_TRUE(rig.power_up());
  EXPECT_EQ(rig.bus.drive(4).object(0x20F0, 2), 700u);
  StiffnessOrder order{{7, 1}, {1000, 1000, 1000, 200, 1000}};
  rig.mailboxes.stiffness.put(order);
  rig.cycles(20);
  EXPECT_EQ(rig.bus.drive(4).object(0x20F0, 2), 200u) << "the drive leads it by itself";
  EXPECT_GT(rig.state.stiffness_permille[kElbow], 500) << "half a second for the whole";
  rig.cycles(60);
  EXPECT_EQ(rig.state.stiffness_permille[kElbow], 200);
}

TEST(Stiffness, ADriveThatLacksTheObjectIsToldOfLoudly) {
  RobotConfig robot = nominal_robot();
  robot.drives[kElbow].stiffness_object = ObjectAddress{0x20F0, 2};
  ArmRig rig(robot);
  rig.bus.drive(4).missing.insert(0x20F0u << 8 | 2);
  ASSERT_TRUE(rig.power_up()) << fault_text(rig.state.fault);
  const auto check = rig.mailboxes.self_check.take();
  ASSERT_TRUE(check);
  EXPECT_NE(to_text(lines_of(*check)).find("node   4  DEGRADED  reactions: 0x20F0:2 wanted 1000"), std::string::npos)
      << to_text(lines_of(*check));
  rig.mailboxes.stiffness.put(StiffnessOrder{{7, 1}, {1000, 1000, 1000, 200, 1000}});
  rig.cycles(200);
  EXPECT_EQ(rig.state.mode, Mode::kHold) << fault_text(rig.state.fault);
}

}  // namespace
}  // namespace armsight::arm::test
