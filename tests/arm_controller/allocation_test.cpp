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

constexpr int kCycles = 1500;

/// Every kind of order, each at its cycle.
void fill(TickInbox& inbox, int cycle, Time now, const ArmRig& rig, const JointVector& q) {
  inbox.lease = Lease{7, now + std::chrono::seconds(1)};
  inbox.mode.reset();
  inbox.proposal.reset();
  inbox.recalibration.reset();
  inbox.goal.reset();
  inbox.hand.reset();
  inbox.look_count = 0;
  const Pose& T_C_B = rig.robot.camera_hint_T_C_B;
  if (cycle == 10) inbox.mode = ModeOrder{{7, 1}, PowerWish::kHold, false};
  if (cycle == 40) inbox.proposal = Proposal{{7, 2}, 0, {0, T_C_B, JointVector::Zero(5)}, false, {}};
  if (cycle == 60) inbox.recalibration = RecalibrationOrder{{7, 3}, false};
  if (cycle == 100) {
    Look& look = inbox.looks[inbox.look_count++];
    look.tag = {7, 4};
    look.capture_time = now - std::chrono::milliseconds(10);
    look.measurement.T_C_H = predict_T_C_H(rig.robot.arm.chain, T_C_B, JointVector::Constant(5, 0.005), q);
    look.measurement.R_vision = 1e-6 * Matrix6::Identity();
    look.measurement.q = q;
  }
  if (cycle == 150) inbox.hand = HandOrder{{7, 5}, 0.5, 300};
  if (cycle == 200) inbox.goal = rig.joint_goal(6, q + JointVector::Constant(5, 0.1));
  if (cycle == 700) {
    inbox.goal = rig.joint_goal(7, q + JointVector::Constant(5, 0.1));
    inbox.goal->kind = GoalKind::kPoseInBase;
    inbox.goal->T_X_G = forward_kinematics(rig.robot.arm.chain, inbox.goal->q_real_rad);
    inbox.goal->model_revision = 2;
    inbox.goal->position_tolerance_m = 1e-3;
    inbox.goal->orientation_tolerance_rad = 0.02;
  }
  if (cycle == 1400) inbox.stop = true;
}

/// What came out, so that no order was refused unseen.
struct Outcome {
  int accepted = 0, refused = 0, arrived = 0, fused = 0;
  void count(const Event& event) {
    if (const auto* answer = std::get_if<AnswerEvent>(&event))
      ++(answer->answer == Answer::kAccepted ? accepted : refused);
    if (const auto* goal = std::get_if<GoalEvent>(&event)) arrived += goal->state == GoalState::kArrived;
    if (const auto* look = std::get_if<FilterEvent>(&event)) fused += look->report.outcome == FusionOutcome::kFused;
  }
};

TEST(Allocation, TheWatchSeesMalloc) {
  t_allocations = 0;
  t_is_watched = true;
  int* volatile one = new int(1);
  t_is_watched = false;
  delete one;
  EXPECT_EQ(t_allocations, 1u);
}

TEST(Allocation, TicksWithEveryKindOfOrderAllocateNothing) {
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
  Outcome outcome;
  Time now = rig.now;
  t_allocations = 0;
  for (int i = 0; i < kCycles; ++i) {
    now += std::chrono::milliseconds(4);
    joints.time = now;
    fill(*inbox, i, now, rig, joints.q_rad);
    t_is_watched = true;
    const TickOutput& output = controller.tick(now, joints, *inbox);
    t_is_watched = false;
    for (std::size_t k = 0; k < output.event_count; ++k) outcome.count(output.events[k]);
    const bool follows = controller.mode() == Mode::kServo || controller.mode() == Mode::kHold;
    if (follows) joints.q_rad = output.command.q_rad;
  }
  EXPECT_EQ(t_allocations, 0u);
  EXPECT_EQ(outcome.refused, 0);
  EXPECT_EQ(outcome.accepted, 7);
  EXPECT_EQ(outcome.fused, 1);
  EXPECT_EQ(outcome.arrived, 2);
  EXPECT_EQ(controller.mode(), Mode::kHold);
}

}  // namespace
}  // namespace armsight::arm::test

#endif
