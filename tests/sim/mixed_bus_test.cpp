// Two drive families behind one seam: shoulder CANopen, elbow and forearm DAMIAO, through a motion and through the
// traps of controller.md §4.6. Verdicts are the simulator's: states of its drives, true angles, frames of the bus.
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "arm_controller/mit_reports.hpp"
#include "tests/sim/closed_loop.hpp"

namespace armsight::sim {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kElbow = 3, kForearm = 4;

void make_damiao(DriveConfig& drive) {
  drive.family = DriveFamily::kDamiao;
  drive.mit.reply_id = static_cast<std::uint8_t>(0x10 + drive.node);
  drive.mit.ranges = {12.5, 10.0, 28.0};  // DM4340
  drive.mit.kp_Nm_rad = 80.0;
  drive.mit.kd_Nms_rad = 2.0;
  drive.mit.softest_kp_Nm_rad = 8.0;
  drive.counts_per_turn = 65535.0 / 25.0 * 2.0 * std::numbers::pi;
}

RobotConfig mixed_robot() {
  RobotConfig robot = load_robot(ARMSIGHT_SOURCE_DIR "/arm_controller/config/ego_right_arm.yaml");
  make_damiao(robot.drives[kElbow]);
  make_damiao(robot.drives[kForearm]);
  robot.drives[kForearm].sign = -1;
  robot.arm.limits.max_speed_rad_s.setConstant(2.0);
  return robot;
}

RobotConfig on_fd(RobotConfig robot) {
  for (DriveConfig& drive : robot.drives) drive.mit.is_fd = drive.family == DriveFamily::kDamiao;
  return robot;
}

RobotConfig on_a_second_bus(RobotConfig robot) {
  robot.drives[kElbow].bus = robot.drives[kForearm].bus = 1;
  return robot;
}

class MixedArm : public testing::Test {
 protected:
  explicit MixedArm(const RobotConfig& robot = mixed_robot()) : arm(robot) {}
  DamiaoDrive& elbow() { return *arm.world().damiao(kElbow); }
  DamiaoDrive& forearm() { return *arm.world().damiao(kForearm); }
  bool bring_to(arm::Mode mode) {
    return arm.cycle_until([&] { return arm.state.mode == mode; }, 2500);
  }
  /// Under way with every joint.
  void start_moving() {
    ASSERT_TRUE(arm.power_up());
    arm.move_to(arm.state.q_reading_rad + JointVector::Constant(5, 0.6));
    arm.cycles(100);
    ASSERT_EQ(arm.state.mode, arm::Mode::kServo);
    ASSERT_GT(arm.world().plant().speed_rad_s(kElbow), 0.3);
  }
  std::string fault() const { return arm::fault_text(arm.state.fault); }
  std::string check_text() const { return arm.self_check ? arm::to_text(arm::lines_of(*arm.self_check)) : "none"; }
  void TearDown() override {
    EXPECT_EQ(elbow().set_zero_orders() + forearm().set_zero_orders(), 0) << "the zero of a drive was moved";
  }

  ClosedLoop arm;
};

class MixedFamilies : public testing::TestWithParam<RobotConfig (*)()> {};

TEST_P(MixedFamilies, GoThroughAMotionTogether) {
  ClosedLoop arm(GetParam()());
  ASSERT_TRUE(arm.power_up()) << arm::fault_text(arm.state.fault);
  EXPECT_EQ(arm.world().damiao(kElbow)->state(), MitState::kEnabled);
  std::map<std::uint32_t, int> seen;
  int fd_frames = 0;
  arm.watch([&](std::size_t, const CanFrame& frame, Time) {
    ++seen[frame.id];
    fd_frames += frame.is_fd ? 1 : 0;
  });
  const JointVector goal = arm.state.q_reading_rad + JointVector::Constant(5, 0.6);
  arm.move_to(goal);
  double farthest = 0.0, fastest = 0.0;
  for (int i = 0; i < 750; ++i) {
    arm.cycle();
    const TraceRow& row = arm.world().trace().back();
    ASSERT_EQ(row.time, arm.state.time) << "the newest SYNC is what the joints were sampled at";
    farthest = std::max(farthest, (row.q_reading - arm.state.q_reading_rad).cwiseAbs().maxCoeff());
    fastest = std::max(fastest, arm.world().plant().speed_rad_s(kElbow));
  }
  EXPECT_EQ(arm.state.mode, arm::Mode::kHold) << arm::fault_text(arm.state.fault);
  EXPECT_LT((arm.encoders() - goal).cwiseAbs().maxCoeff(), 0.004) << "the arm is not at the goal";
  EXPECT_GT(fastest, 1.0);
  EXPECT_LT(farthest, 0.0008) << "a reading of another instant: 1 ms at 1 rad/s is 1 mrad";
  const std::uint32_t elbow = arm.robot.drives[kElbow].node;
  EXPECT_NEAR(seen[elbow], 750, 2) << "a command a cycle";
  EXPECT_NEAR(seen[0x10 + elbow], 750, 2) << "a sample a cycle";
  EXPECT_NEAR(fd_frames, arm.robot.drives[kElbow].mit.is_fd ? 4 * 750 : 0, 8);
}

INSTANTIATE_TEST_SUITE_P(Buses, MixedFamilies,
                         testing::Values(+[] { return mixed_robot(); }, +[] { return on_fd(mixed_robot()); },
                                         +[] { return on_a_second_bus(mixed_robot()); },
                                         +[] { return on_fd(on_a_second_bus(mixed_robot())); }));

RobotConfig heavy_robot() {
  RobotConfig robot = mixed_robot();
  robot.soft.links[kElbow] = {1.0, {0.0, 0.0, 0.1}};
  return robot;
}

class HeavyArm : public MixedArm {
 protected:
  HeavyArm() : MixedArm(heavy_robot()) {}
  double load_Nm() const {
    const SoftArm& soft = arm.robot.soft;
    return gravity_torque(soft.chain, soft.links, soft.gravity_m_s2, arm.state.q_reading_rad)[kElbow];
  }
};

// Judged by what the drive itself says of its torque, and by its encoder.
TEST_F(HeavyArm, GravityIsFedForwardSoThatTheImpedanceDoesNotGiveWay) {
  ASSERT_TRUE(arm.power_up());
  const double before = arm.encoders()[kElbow];
  arm.cycles(250);
  ASSERT_GT(std::abs(load_Nm()), 0.3) << "nothing to hold";
  EXPECT_NEAR(arm.encoders()[kElbow], before, 0.0005);
  EXPECT_NEAR(arm.state.torque_Nm[kElbow], load_Nm(), 0.05);
}

TEST_F(MixedArm, SoftJointsGiveWayByTorqueOverStiffness) {
  elbow().push_Nm = 1.0;  // somebody leans on it
  ASSERT_TRUE(arm.power_up());
  arm.cycles(250);
  const double stiff = arm.encoders()[kElbow] - arm.state.q_command_rad[kElbow];
  EXPECT_NEAR(std::abs(stiff), 1.0 / 80.0, 0.001);
  arm.soften({1000, 1000, 1000, 0, 1000});
  arm.cycles(250);
  const double soft = arm.encoders()[kElbow] - arm.state.q_command_rad[kElbow];
  EXPECT_NEAR(std::abs(soft), 1.0 / 8.0, 0.005) << "a tenth of the stiffness";
  EXPECT_EQ(arm.state.mode, arm::Mode::kHold) << fault();
}

TEST_F(MixedArm, AWrongModeIsSilentSoItIsAskedFirstAndSet) {
  elbow().mode_at_power_on = 2;
  elbow().power_on(Time{});
  ASSERT_TRUE(arm.power_up()) << fault();
  EXPECT_EQ(elbow().register_value(MitRegister::kControlMode), kMitMode);
  EXPECT_NE(check_text().find("DEGRADED  registers: control mode was 2, in which it answers no command"),
            std::string::npos) << check_text();
}

TEST_F(MixedArm, AModeThatCannotBeSetIsRefused) {
  elbow().mode_at_power_on = 2;
  elbow().power_on(Time{});
  elbow().stuck = MitRegister::kControlMode;
  ASSERT_TRUE(bring_to(arm::Mode::kFault));
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kReadBackDiffers);
  EXPECT_EQ(fault(), "motor 4: wrote 1 to register 10 (control mode), read back 2");
}

TEST_F(MixedArm, ItsTimeOutIsSetToTheDeadline) {
  ASSERT_TRUE(arm.power_up());
  EXPECT_EQ(elbow().register_value(MitRegister::kTimeout), 360u) << "18 ms in steps of 50 us";
  EXPECT_NE(check_text().find("lets go 18.0 ms after the last command: no quick stop, no hold"), std::string::npos)
      << check_text();
}

TEST_F(MixedArm, ATimeOutThatStaysOffIsRefused) {
  forearm().stuck = MitRegister::kTimeout;
  ASSERT_TRUE(bring_to(arm::Mode::kFault));
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kNoSupervision);
  EXPECT_EQ(fault(), "motor 5: its time-out (register 9) stays off: it would follow its last command for ever");
  EXPECT_EQ(forearm().state(), MitState::kDisabled);
}

TEST_F(MixedArm, ADeadControllerMakesItLetGo) {
  start_moving();
  arm.die_for(19ms);
  EXPECT_EQ(elbow().state(), MitState::kEnabled);
  arm.die_for(6ms);
  EXPECT_EQ(elbow().state(), MitState::kCommandsLost);
  EXPECT_EQ(arm.world().node(0).state(), DriveState::kQuickStopActive) << "the CANopen drives brake and hold";
}

TEST_F(MixedArm, ALostDriveStopsAll) {
  start_moving();
  elbow().is_silent = true;
  arm.cycles(4);
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kFeedbackMissing);
  EXPECT_NE(fault().find("motor 4: third sample in a row missing, last seen"), std::string::npos) << fault();
  arm.cycles(100);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(arm.world().plant().speed_rad_s(i), 0.0) << "joint " << i;
  EXPECT_LT(std::abs(arm.world().plant().speed_rad_s(kForearm)), 1e-4) << "its neighbour of the same family holds";
  EXPECT_EQ(forearm().state(), MitState::kEnabled);
}

TEST_F(MixedArm, TwoSamplesInARowMayBeMissing) {
  start_moving();
  elbow().dropped_samples = 2;
  arm.cycles(100);
  EXPECT_EQ(arm.state.mode, arm::Mode::kServo) << fault();
  elbow().dropped_samples = 3;
  arm.cycles(5);
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kFeedbackMissing);
}

TEST_F(MixedArm, AFaultIsNamedAndClearedWithoutAJump) {
  start_moving();
  elbow().fail(MitState::kOverCurrent);
  arm.cycles(2);
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kDriveFault);
  EXPECT_EQ(fault(), "motor 4: drive fault, over-current");
  arm.cycles(100);
  const JointVector before = arm.world().plant().q_real();
  arm.order(arm::PowerWish::kHold, true);
  for (int i = 0; i < 12; ++i) {
    arm.cycle();
    ASSERT_EQ(forearm().state(), MitState::kEnabled) << "let go while its registers were asked, cycle " << i;
  }
  ASSERT_TRUE(bring_to(arm::Mode::kHold)) << fault();
  EXPECT_EQ(elbow().state(), MitState::kEnabled);
  EXPECT_LT((arm.world().plant().q_real() - before).cwiseAbs().maxCoeff(), 0.002);
}

TEST_F(MixedArm, AStopIsARampToRest) {
  start_moving();
  const double at = arm.world().plant().q_real()[kForearm];
  elbow().is_silent = true;
  arm.cycles(60);
  EXPECT_LT(std::abs(arm.world().plant().q_real()[kForearm] - at), 0.15) << "2 rad/s at 20 rad/s2 and four cycles";
  EXPECT_EQ(forearm().state(), MitState::kEnabled);
}

TEST_F(MixedArm, RangesThatDifferFromTheFileAreRefused) {
  elbow().set_register(MitRegister::kSpeedRange, 0x41F00000);  // 30
  ASSERT_TRUE(bring_to(arm::Mode::kFault));
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kWrongIdentity);
  EXPECT_EQ(fault(), "motor 4: register 22 (speed range) is 30, the configuration asks for 10");
}

TEST_F(MixedArm, AnAbsentDriveIsNamed) {
  elbow().is_silent = true;
  ASSERT_TRUE(bring_to(arm::Mode::kFault));
  EXPECT_EQ(fault(), "motor 4: no answer to any register in 3 s");
}

class WokeUpBeside : public testing::TestWithParam<int> {};

TEST_P(WokeUpBeside, IsPutRightByTheLimits) {
  ClosedLoop arm(mixed_robot());
  for (const std::size_t joint : {kElbow, kForearm}) {
    arm.world().damiao(joint)->turns_at_power_on = GetParam();
    arm.world().damiao(joint)->power_on(Time{});
  }
  ASSERT_TRUE(arm.power_up()) << arm::fault_text(arm.state.fault);
  EXPECT_LT((arm.encoders() - arm.state.q_reading_rad).cwiseAbs().maxCoeff(), 0.0005);
  const JointVector goal = arm.state.q_reading_rad + JointVector::Constant(5, 0.3);
  arm.move_to(goal);
  arm.cycles(600);
  EXPECT_LT((arm.encoders() - goal).cwiseAbs().maxCoeff(), 0.004);
}

INSTANTIATE_TEST_SUITE_P(Turns, WokeUpBeside, testing::Values(-1, 0, 1));

/// The forearm may turn by more than a turn.
RobotConfig turning_robot() {
  RobotConfig robot = mixed_robot();
  robot.arm.limits.min_rad[kForearm] = -6.2;
  robot.arm.limits.max_rad[kForearm] = 6.2;
  return robot;
}

TEST(WokeUp, WithinLimitsOfMoreThanATurnNobodyKnowsWhere) {
  ClosedLoop arm(turning_robot());
  ASSERT_TRUE(arm.cycle_until([&] { return arm.state.mode == arm::Mode::kFault; }, 2500));
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kTurnUnknown) << arm::fault_text(arm.state.fault);
}

TEST(WokeUp, WithinSuchLimitsTheLastPositionTells) {
  const JointVector last_seen = ClosedLoop(turning_robot()).world().plant().q_real();
  ClosedLoop arm(turning_robot(), last_seen);
  arm.world().damiao(kForearm)->turns_at_power_on = 1;
  arm.world().damiao(kForearm)->power_on(Time{});
  ASSERT_TRUE(arm.power_up()) << arm::fault_text(arm.state.fault);
  EXPECT_LT((arm.state.q_reading_rad - arm.encoders()).cwiseAbs().maxCoeff(), 0.0005);
  EXPECT_LT(std::abs(arm.state.q_reading_rad[kForearm] - last_seen[kForearm]), 0.2) << "its offset, and no turn";
}

}  // namespace
}  // namespace armsight::sim
