// The cycle allocates nothing: malloc itself is watched while it runs.
#include <gtest/gtest.h>
#include <stddef.h>

#include "tests/arm_controller/arm_rig.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {
thread_local bool t_is_watched = false;
thread_local std::size_t t_allocations = 0;
}  // namespace

extern "C" {
void* __libc_malloc(size_t size);
void* malloc(size_t size) {
  if (t_is_watched) ++t_allocations;
  return __libc_malloc(size);
}
}

namespace armsight::arm::test {
namespace {

TEST(Allocation, ATickWithGoalHandLookAndProposalAllocatesNothing) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.cycles(40);
  Controller controller(rig.robot, nominal_start(rig.robot));
  JointSamples joints;
  joints.q_rad = rig.q_reading();
  joints.torque_Nm = JointVector::Zero(5);
  joints.has_positions = joints.is_fresh = true;
  joints.phase = BusPhase::kPowered;
  auto inbox = std::make_unique<TickInbox>();
  Time now = rig.now;
  t_allocations = 0;
  for (int i = 0; i < 1500; ++i) {
    now += std::chrono::milliseconds(4);
    joints.time = now;
    inbox->lease = Lease{7, now + std::chrono::seconds(1)};
    inbox->mode.reset();
    inbox->goal.reset();
    inbox->look_count = 0;
    if (i == 10) inbox->mode = ModeOrder{{7, 1}, PowerWish::kHold, false};
    inbox->recalibration.reset();
    if (i == 60) inbox->recalibration = RecalibrationOrder{{7, 2}, false};
    if (i == 100) {
      inbox->look_count = 1;
      Look& look = inbox->looks[0];
      look.capture_time = now - std::chrono::milliseconds(10);
      look.measurement.T_C_H = predict_T_C_H(rig.robot.arm.chain, rig.robot.camera_hint_T_C_B, JointVector::Zero(5),
                                             joints.q_rad);
      look.measurement.R_vision = 1e-6 * Matrix6::Identity();
      look.measurement.q = joints.q_rad;
    }
    if (i == 200) inbox->goal = rig.joint_goal(3, joints.q_rad + JointVector::Constant(5, 0.1));
    t_is_watched = true;
    const TickOutput& output = controller.tick(now, joints, *inbox);
    t_is_watched = false;
    if (controller.mode() == Mode::kServo || controller.mode() == Mode::kHold) joints.q_rad = output.command.q_rad;
  }
  EXPECT_EQ(t_allocations, 0u);
  EXPECT_EQ(controller.mode(), Mode::kHold);
}

}  // namespace
}  // namespace armsight::arm::test

#endif
