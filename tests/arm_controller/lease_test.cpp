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

}  // namespace
}  // namespace armsight::arm::test
