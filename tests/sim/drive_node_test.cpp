// The simulated drive: CiA 402 transitions, set-points that act with SYNC, and what it does when the controller is
// gone.
#include <gtest/gtest.h>

#include "tests/sim/drive_bench.hpp"

namespace armsight::sim {
namespace {

using namespace std::chrono_literals;
using enum DriveState;

TEST(DriveStates, FollowTheControlwordFromEveryState) {
  struct Row {
    DriveState from;
    DriveState shutdown, switch_on, enable, quick_stop, disable;
  };
  const Row table[] = {
      {kNotReady, kNotReady, kNotReady, kNotReady, kNotReady, kNotReady},
      {kFaultReaction, kFaultReaction, kFaultReaction, kFaultReaction, kFaultReaction, kFaultReaction},
      {kSwitchOnDisabled, kReadyToSwitchOn, kSwitchOnDisabled, kSwitchOnDisabled, kSwitchOnDisabled, kSwitchOnDisabled},
      {kReadyToSwitchOn, kReadyToSwitchOn, kSwitchedOn, kSwitchedOn, kSwitchOnDisabled, kSwitchOnDisabled},
      {kSwitchedOn, kReadyToSwitchOn, kSwitchedOn, kOperationEnabled, kSwitchOnDisabled, kSwitchOnDisabled},
      {kOperationEnabled, kReadyToSwitchOn, kSwitchedOn, kOperationEnabled, kQuickStopActive, kSwitchOnDisabled},
      {kQuickStopActive, kQuickStopActive, kQuickStopActive, kOperationEnabled, kQuickStopActive, kSwitchOnDisabled},
      {kFault, kFault, kFault, kFault, kFault, kFault}};
  for (const Row& row : table) {
    EXPECT_EQ(next_drive_state(row.from, kShutdown, 6, false), row.shutdown) << to_text(row.from);
    EXPECT_EQ(next_drive_state(row.from, kSwitchOn, 6, false), row.switch_on) << to_text(row.from);
    EXPECT_EQ(next_drive_state(row.from, kEnableOperation, 6, false), row.enable) << to_text(row.from);
    EXPECT_EQ(next_drive_state(row.from, kQuickStop, 6, false), row.quick_stop) << to_text(row.from);
    EXPECT_EQ(next_drive_state(row.from, kDisableVoltage, 6, false), row.disable) << to_text(row.from);
    EXPECT_EQ(drive_state(state_bits(row.from)), row.from) << "statusword says what it is";
  }
  EXPECT_EQ(next_drive_state(kQuickStopActive, kEnableOperation, 2, false), kQuickStopActive)
      << "option 2: no way back";
  for (const DriveState state : {kNotReady, kSwitchOnDisabled, kReadyToSwitchOn, kSwitchedOn, kOperationEnabled,
                                 kQuickStopActive, kFaultReaction, kFault})
    EXPECT_EQ(next_drive_state(state, kFaultReset, 6, true),
              state == kNotReady || state == kFaultReaction ? state : kSwitchOnDisabled)
        << to_text(state) << ": 0x80 resets a fault; elsewhere its low bits disable the voltage";
}

struct Drive : ::testing::Test {
  test::DriveBench bench;
  void SetUp() override {
    bench.configure();
    bench.start();
  }
};

TEST_F(Drive, AnswersSyncWithTheSampleBeforeItsSetPointActs) {
  const auto first = bench.cycle(kShutdown, 0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->position_counts, 1000);
  EXPECT_EQ(first->torque, 12);
  EXPECT_EQ(drive_state(first->statusword), kSwitchOnDisabled);
  const auto second = bench.cycle(kShutdown, 0);
  EXPECT_EQ(drive_state(second->statusword), kReadyToSwitchOn);
}

TEST_F(Drive, EnablesByTheSequenceAndFollows) {
  bench.enable();
  EXPECT_EQ(bench.drive.state(), kOperationEnabled);
  const auto tpdo = bench.cycle(kEnableOperation, 1200);
  EXPECT_NE(tpdo->statusword & 0x1000, 0) << "follows its target";
  EXPECT_EQ(bench.motor.mode, MotorMode::kFollow);
  EXPECT_EQ(bench.motor.target, 1200);
}

TEST_F(Drive, SetPointsWaitForSync) {
  bench.enable();
  bench.send(encode(Rpdo1{kEnableOperation, 1500, 0}, 3));
  EXPECT_NE(bench.motor.target, 1500);
  bench.send(encode(Sync{1}));
  EXPECT_EQ(bench.motor.target, 1500);
}

TEST_F(Drive, AMissedDeadlineMakesItQuickStopAndHoldPowered) {
  bench.enable();
  bench.cycle(kEnableOperation, 1000);
  bench.take();
  bench.advance(15ms);
  EXPECT_EQ(bench.drive.state(), kOperationEnabled) << "19 ms after the last set-point";
  bench.advance(2ms);
  EXPECT_EQ(bench.drive.state(), kQuickStopActive);
  EXPECT_EQ(bench.motor.mode, MotorMode::kStop);
  ASSERT_FALSE(bench.sent.empty());
  EXPECT_EQ(decode_emcy(bench.sent.back(), 3)->code, 0x8250);
}

TEST_F(Drive, AStallOfTheSimulatorIsNoSilenceOfTheController) {
  bench.enable();
  bench.cycle(kEnableOperation, 1000);
  bench.drive.excuse(14ms);
  bench.advance(29ms);
  EXPECT_EQ(bench.drive.state(), kOperationEnabled) << "33 ms after the last set-point, of which 14 do not count";
  bench.advance(2ms);
  EXPECT_EQ(bench.drive.state(), kQuickStopActive) << "the rest counts";
}

TEST_F(Drive, ALateControllerMustReleaseBeforeItMovesAgain) {
  bench.enable();
  bench.advance(30ms);
  ASSERT_EQ(bench.drive.state(), kQuickStopActive);
  bench.cycle(kEnableOperation, 1000);
  EXPECT_EQ(bench.drive.state(), kQuickStopActive) << "the same command goes on: ignored";
  bench.cycle(kQuickStop, 1000);
  bench.cycle(kEnableOperation, 1000);
  EXPECT_EQ(bench.drive.state(), kOperationEnabled);
}

TEST_F(Drive, ALostHeartbeatStopsIt) {
  bench.write(0x1400, 1, 0x80000203, 4);
  bench.write(0x1400, 5, 0, 2);
  bench.write(0x1400, 1, 0x203, 4);
  bench.enable();
  bench.send(encode(Heartbeat{NmtState::kOperational}, kControllerNode));
  bench.advance(249ms);
  EXPECT_EQ(bench.drive.state(), kOperationEnabled);
  bench.take();
  bench.advance(2ms);
  EXPECT_EQ(bench.drive.state(), kQuickStopActive);
  bool said_so = false;
  for (const CanFrame& frame : bench.sent)
    said_so = said_so || (decode_emcy(frame, 3) && decode_emcy(frame, 3)->code == 0x8130);
  EXPECT_TRUE(said_so);
}

TEST_F(Drive, ATargetFarAwayIsAFaultNotAJump) {
  bench.enable();
  bench.cycle(kEnableOperation, 20'000);
  EXPECT_EQ(bench.drive.state(), kFault);
  EXPECT_NE(bench.motor.mode, MotorMode::kFollow);
  EXPECT_EQ(bench.read(0x603F, 0), 0x8611u);
  bench.cycle(0x00, 1000);
  bench.cycle(kFaultReset, 1000);
  EXPECT_EQ(bench.drive.state(), kSwitchOnDisabled);
  EXPECT_EQ(bench.read(0x603F, 0), 0u);
}

TEST_F(Drive, LeavingOperationalStopsItAndResetStartsAnew) {
  bench.enable();
  bench.send(encode(Nmt{NmtCommand::kPreOperational, 3}));
  EXPECT_EQ(bench.drive.state(), kQuickStopActive);
  bench.take();
  bench.send(encode(Nmt{NmtCommand::kResetNode, 3}));
  EXPECT_EQ(bench.sent.front(), (CanFrame{0x703, 1, {0x00}}));
  EXPECT_EQ(bench.read(0x1600, 0), 0u) << "nothing configured any more";
}

TEST_F(Drive, InCyclicVelocityMovesByTheSpeedTold) {
  bench.send(encode(Nmt{NmtCommand::kPreOperational, 3}));
  bench.write(0x1400, 1, 0x80000203, 4);
  bench.write(0x1600, 0, 0, 1);
  EXPECT_EQ(bench.write(0x1600, 2, 0x60FF0020, 4), 0u);
  bench.write(0x1600, 0, 3, 1);
  bench.write(0x1400, 1, 0x203, 4);
  EXPECT_EQ(bench.write(0x6060, 0, 9, 1), 0u);
  bench.start();
  for (const std::uint16_t cw : {kShutdown, kSwitchOn, kEnableOperation}) bench.cycle(cw, 0);
  EXPECT_EQ(bench.motor.target, 1000);
  for (int i = 0; i < 10; ++i) bench.cycle(kEnableOperation, 2500);
  EXPECT_NEAR(bench.motor.target, 1100, 11) << "ten cycles of 4 ms at 2500 counts/s";
  EXPECT_NE(bench.cycle(kEnableOperation, 0)->statusword & 0x1000, 0);
}

TEST_F(Drive, InProfilePositionTakesATargetWhenBit4RisesAndAcknowledges) {
  bench.write(0x6060, 0, 1, 1);
  bench.write(0x6081, 0, 50'000, 4);
  bench.enable();
  bench.cycle(kEnableOperation, 1400);
  EXPECT_EQ(bench.motor.target, 1000) << "not without the edge";
  bench.cycle(kEnableOperation | 0x30, 1400);
  EXPECT_NE(bench.cycle(kEnableOperation | 0x30, 1700)->statusword & 0x1000, 0) << "acknowledged";
  EXPECT_EQ(bench.cycle(kEnableOperation | 0x20, 1700)->statusword & 0x1000, 0x1000) << "the sample before it acts";
  EXPECT_EQ(bench.cycle(kEnableOperation | 0x20, 1700)->statusword & 0x1000, 0);
  for (int i = 0; i < 10; ++i) bench.cycle(kEnableOperation, 1700);
  EXPECT_EQ(bench.motor.target, 1400);
}

TEST_F(Drive, HomesWhereItStandsWithoutMoving) {
  for (const std::uint32_t method : {35u, 37u}) {
    bench.write(0x6098, 0, method, 1);
    bench.write(0x607C, 0, 50, 4);
    bench.write(0x6060, 0, 6, 1);
    bench.enable();
    bench.cycle(kEnableOperation | 0x10, 0);
    const auto homed = bench.cycle(kEnableOperation | 0x10, 0);
    EXPECT_EQ(homed->position_counts, 50);
    EXPECT_EQ(homed->statusword & 0x3400, 0x1400) << "attained and reached, no error";
    EXPECT_EQ(bench.motor.target, 1000) << "the motor stands";
    bench.cycle(kShutdown, 0);
  }
  EXPECT_EQ(bench.write(0x6098, 0, 33, 1), kBadValue);
}

TEST_F(Drive, ProducesItsHeartbeat) {
  bench.write(0x1017, 0, 100, 2);
  bench.take();
  bench.advance(350ms);
  int beats = 0;
  for (const CanFrame& frame : bench.sent) beats += decode_heartbeat(frame, 3) ? 1 : 0;
  EXPECT_EQ(beats, 3);
}

}  // namespace
}  // namespace armsight::sim
