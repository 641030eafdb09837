// Row 8: an encoder jumps, loses a whole turn, freezes, trembles. The arm stops, and what the encoder did is never
// learnt as an offset of the joint.
#include <numbers>

#include "shared/hand_eye.hpp"
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;
using arm::FaultCode;

class FailingEncoder : public ::testing::Test {
 protected:
  FaultRig rig;

  void expect_all_stopped(Time since, double within_rad) {
    for (int node = 1; node <= kNodes; ++node)
      EXPECT_TRUE(rig.left(node, DriveState::kOperationEnabled, since)) << "drive " << node << " goes on";
    EXPECT_EQ(rig.fastest_rad_s(), 0.0);
    EXPECT_LT(rig.travelled_rad(since), within_rad);
  }
  /// What the camera sees is the true hand.
  arm::Look true_look() const {
    arm::Look look;
    look.tag = {7, 1'000'000 + rig.log.size()};
    look.capture_time = rig.now - 20ms;
    look.time_bound = 1ms;
    look.measurement.T_C_H =
        predict_T_C_H(rig.robot.arm.chain, rig.robot.camera_hint_T_C_B, JointVector::Zero(kJoints), rig.q_rad());
    look.measurement.R_vision = 1e-7 * Matrix6::Identity();
    look.measurement.q = JointVector::Zero(kJoints);
    return look;
  }
};

TEST_F(FailingEncoder, JumpUnderWayStops) {
  ASSERT_TRUE(rig.start_moving());
  const Time began = rig.now;
  rig.world->plant().set_encoder_fault(1, {.offset_rad = 0.6});
  rig.cycles(100);
  expect_all_stopped(began, 0.1);
}

/// The drive's own loop chases its frozen encoder until somebody notices: 1.46 rad until the mechanical end, unnoticed.
TEST_F(FailingEncoder, FrozenStopsBeforeTheDriveHasChasedItFar) {
  ASSERT_TRUE(rig.start_moving());
  const Time began = rig.now;
  rig.world->plant().set_encoder_fault(0, {.is_frozen = true});
  rig.cycles(400);
  expect_all_stopped(began, 0.2);
}

/// Set-point, SYNC, answer: a cycle each, and twenty cycles a second.
TEST_F(FailingEncoder, IsNotSeenInASlowCycle) {
  RobotConfig robot = shipped_robot();
  robot.controller.period_s = 0.05;
  robot.controller.rpdo_deadline_s = 0.6;
  robot.controller.heartbeat_s = 1.5;
  robot.controller.lease_s = 1.0;
  FaultRig slow(robot);
  ASSERT_TRUE(slow.power_up());
  slow.send_goal(FaultRig::far_goal());
  EXPECT_TRUE(slow.cycle_until([&] { return (slow.q_rad() - FaultRig::far_goal()).cwiseAbs().maxCoeff() < 5e-3; }, 200))
      << fault_text(slow.state.fault);
  EXPECT_TRUE(slow.all_drives(DriveState::kOperationEnabled));
}

TEST_F(FailingEncoder, TremblingByThreeCountsIsCarried) {
  for (int joint = 0; joint < kJoints; ++joint) rig.world->plant().set_encoder_fault(joint, {.tremble_rad = 6e-4});
  ASSERT_TRUE(rig.start_moving());
  EXPECT_TRUE(rig.cycle_until(
      [&] { return (rig.q_rad() - FaultRig::far_goal()).cwiseAbs().maxCoeff() < 5e-3; }, 1500));
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

TEST_F(FailingEncoder, AWholeTurnOffSinceTheLastRunIsNeverEnabled) {
  rig.kill_controller();
  rig.last_seen_rad = rig.q_rad();
  rig.world->plant().set_encoder_fault(0, {.offset_rad = -2.0 * std::numbers::pi});
  rig.start_controller();
  for (int i = 0; i < 500; ++i) {
    rig.cycle();
    if (i % 50 == 0) rig.order_mode(arm::PowerWish::kHold);
    ASSERT_TRUE(rig.no_drive(DriveState::kOperationEnabled)) << "cycle " << i;
  }
  EXPECT_EQ(rig.named(), FaultCode::kWholeTurn);
}

TEST_F(FailingEncoder, JumpIsNeverLearntAsAnOffset) {
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.recalibration.put({{7, 500'000}, false});
  rig.cycles(60);
  rig.mailboxes.looks.push(true_look());
  rig.cycles(60);
  ASSERT_LT(rig.state.model.beta.cwiseAbs().maxCoeff(), 1e-3) << "the model is right";
  const double learnt = rig.state.model.beta[1];
  rig.world->plant().set_encoder_fault(1, {.offset_rad = 0.6});
  rig.cycles(100);
  ASSERT_TRUE(rig.no_drive(DriveState::kOperationEnabled));
  for (int i = 0; i < 500; ++i) {
    if (i % 100 == 0) rig.order_mode(arm::PowerWish::kHold, true);  // somebody insists
    if (i % 20 == 0) rig.mailboxes.recalibration.put({{7, 600'000u + static_cast<unsigned>(i)}, false});
    if (i % 20 == 10) rig.mailboxes.looks.push(true_look());
    rig.cycle();
    ASSERT_TRUE(rig.no_drive(DriveState::kOperationEnabled)) << "cycle " << i;
  }
  EXPECT_NEAR(rig.state.model.beta[1], learnt, 1e-3);
  EXPECT_EQ(rig.named(), FaultCode::kEncoderStep);
}

TEST_F(FailingEncoder, ComesBackOnceItReadsAgainWhatItRead) {
  ASSERT_TRUE(rig.power_up());
  rig.world->plant().set_encoder_fault(1, {.offset_rad = 0.6});
  rig.cycles(50);
  ASSERT_TRUE(rig.no_drive(DriveState::kOperationEnabled));
  rig.world->plant().set_encoder_fault(1, {});
  rig.order_mode(arm::PowerWish::kHold, true);
  EXPECT_TRUE(rig.cycle_until([&] { return rig.all_drives(DriveState::kOperationEnabled); }, 1000));
}

/// Too small a step to be told from a motion: the drive itself moves the joint by it, and the camera sees the hand off.
TEST_F(FailingEncoder, SmallStepIsRefusedByTheFilterAndSaid) {
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.recalibration.put({{7, 500'000}, false});
  rig.cycles(60);
  for (int i = 0; i < 5; ++i) {
    rig.mailboxes.looks.push(true_look());
    rig.cycles(60);
  }
  const double learnt = rig.state.model.beta[1];
  rig.world->plant().set_encoder_fault(1, {.offset_rad = 0.045});
  rig.cycles(250);
  rig.mailboxes.looks.push(true_look());
  rig.cycles(20);
  EXPECT_NEAR(rig.state.model.beta[1], learnt, 1e-3);
  ASSERT_TRUE(rig.last<arm::FilterEvent>());
  EXPECT_EQ(rig.last<arm::FilterEvent>()->report.outcome, FusionOutcome::kRejectedByGate);
}

}  // namespace
}  // namespace armsight::faults
