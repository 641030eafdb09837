// Who holds the lease when the tick takes an order: the link has judged the message, but the lease may end on the way.
#include <gtest/gtest.h>

#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

Goal far_goal(const ArmRig& rig) { return rig.joint_goal(1, rig.q_reading() + JointVector::Constant(5, 0.4)); }

// The link runs more often than the cycle: of an end and a new beginning in between, the slot keeps the beginning.
TEST(Lease, AnotherHolderWithinOneCycleFindsTheArmStoppedAndTheRecalibrationClosed) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.recalibration.put({{7, 1}, false});
  rig.mailboxes.goal.put(far_goal(rig));
  rig.cycles(50);
  ASSERT_EQ(rig.state.mode, Mode::kServo);
  rig.commander = 8;
  rig.cycle();
  EXPECT_EQ(rig.state.mode, Mode::kStopping);
  EXPECT_EQ(rig.last<GoalEvent>()->state, GoalState::kStopped);
  Look look;
  look.tag = {8, 1};
  look.capture_time = rig.now - std::chrono::milliseconds(20);
  rig.mailboxes.looks.push(look);
  rig.cycle();
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
}

TEST(Lease, AfterItsEndNoOrderActs) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.has_commander = false;
  rig.cycles(60);
  rig.order_mode(PowerWish::kHold);
  rig.mailboxes.goal.put(far_goal(rig));
  rig.mailboxes.hand.put({{7, 2}, 1.0, 300});
  rig.mailboxes.recalibration.put({{7, 3}, false});
  rig.mailboxes.proposal.put({{7, 4}, 0, rig.state.model, false, {}});
  rig.mailboxes.looks.push({{7, 5}, rig.now, {}, {}});
  rig.events.clear();
  rig.cycles(200);
  EXPECT_EQ(rig.state.mode, Mode::kReady);
  ASSERT_EQ(rig.events.size(), 6u);
  for (const Event& event : rig.events) EXPECT_EQ(std::get<AnswerEvent>(event).answer, Answer::kNoLease);
}

TEST(Lease, AnOrderOfItsLastHolderDoesNotActUnderTheNext) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.commander = 8;
  rig.mailboxes.goal.put(far_goal(rig));  // tagged 7
  rig.cycle();
  EXPECT_EQ(rig.last_answer(), Answer::kNoLease);
  EXPECT_EQ(rig.state.mode, Mode::kHold);
}

TEST(Stop, WinsOverAHoldOfTheSameCycle) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.order_mode(PowerWish::kHold);
  rig.mailboxes.stop.set();
  rig.cycle();
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
  rig.cycles(200);
  EXPECT_EQ(rig.state.mode, Mode::kReady);
}

}  // namespace
}  // namespace armsight::arm::test
