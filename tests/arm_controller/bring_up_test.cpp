// Drives are brought up in the order they accept, everything written is read back, and every refusal has a name.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

std::size_t position(const FakeDrive& drive, const std::string& entry) {
  const auto found = std::find(drive.log.begin(), drive.log.end(), entry);
  EXPECT_NE(found, drive.log.end()) << entry;
  return static_cast<std::size_t>(found - drive.log.begin());
}

TEST(BringUp, ReachesReadyWithPowerOff) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.cycles(200);
  EXPECT_EQ(rig.state.mode, Mode::kReady);
  EXPECT_EQ(rig.bus.drive(1).state, DriveState::kReadyToSwitchOn);
}

TEST(BringUp, KeepsTheOrderThatDrivesAccept) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  const FakeDrive& drive = rig.bus.drive(3);
  const std::vector<std::string> order{
      "nmt 128",        "r 1000:0",       "r 6502:0",       "w 6007:0 3",       "w 605A:0 6",
      "w 605E:0 2",     "w 1400:1 80000203", "w 1400:2 1",  "w 1600:0 0",       "w 1600:1 60400010",
      "w 1600:2 607A0020", "w 1600:3 60B20010", "w 1600:0 3", "w 1400:5 12",    "w 1400:1 203",
      "w 1800:1 C0000183", "w 1A00:0 0",  "w 1A00:3 60770010", "w 1800:1 40000183", "w 1016:1 7F00FA",
      "w 1017:0 64",    "w 60C2:1 4",     "w 60C2:2 FD",    "w 6060:0 8",       "r 6060:0",
      "nmt 1"};
  for (std::size_t i = 1; i < order.size(); ++i)
    EXPECT_LT(position(drive, order[i - 1]), position(drive, order[i])) << order[i - 1] << " before " << order[i];
}

TEST(BringUp, ReadsBackWhatItWrote) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  for (const char* object : {"6007:0", "605A:0", "605E:0", "1400:2", "1600:1", "1600:2", "1600:3", "1600:0", "1400:5",
                             "1400:1", "1800:2", "1A00:0", "1800:1", "1016:1", "1017:0", "60C2:1", "60C2:2", "6060:0"})
    position(rig.bus.drive(1), std::string("r ") + object);
}

struct Refusal {
  const char* name;
  std::function<void(FakeDrive&)> bend;
  FaultCode code;
};

class BringUpRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(BringUpRefuses, AndNamesTheNode) {
  ArmRig rig;
  GetParam().bend(rig.bus.drive(2));
  ASSERT_TRUE(rig.bring_to(Mode::kFault)) << to_text(rig.state.mode);
  EXPECT_EQ(rig.state.fault.code, GetParam().code) << fault_text(rig.state.fault);
  EXPECT_EQ(rig.state.fault.node, 2);
  for (FakeDrive& drive : rig.bus.drives()) EXPECT_NE(drive.state, DriveState::kOperationEnabled);
}

INSTANTIATE_TEST_SUITE_P(
    EveryPath, BringUpRefuses,
    testing::Values(
        Refusal{"Absent", [](FakeDrive& d) { d.is_silent = true; }, FaultCode::kNodeAbsent},
        Refusal{"NotADrive", [](FakeDrive& d) { d.stuck[0x100000] = 0x191; }, FaultCode::kWrongIdentity},
        Refusal{"NoCsp", [](FakeDrive& d) { d.stuck[0x650200] = 0x121; }, FaultCode::kWrongIdentity},
        Refusal{"OtherEncoder", [](FakeDrive& d) { d.stuck[0x608F01] = 4096; }, FaultCode::kWrongIdentity},
        Refusal{"ModeNotTaken", [](FakeDrive& d) { d.stuck[0x606000] = 1; }, FaultCode::kReadBackDiffers},
        Refusal{"NoSupervision", [](FakeDrive& d) { d.missing = {0x101601, 0x140005}; }, FaultCode::kNoSupervision},
        Refusal{"NoMapping", [](FakeDrive& d) { d.missing.insert(0x1A0001); }, FaultCode::kSdoAborted},
        Refusal{"MappingIgnored", [](FakeDrive& d) { d.stuck[0x160002] = 0x60FF0020; }, FaultCode::kReadBackDiffers},
        Refusal{"NoFeedback", [](FakeDrive& d) { d.sends_feedback = false; }, FaultCode::kFeedbackMissing}),
    [](const auto& one) { return one.param.name; });

TEST(BringUp, FallsBackWhereTheDriveRefusesToStayPoweredOnQuickStop) {
  ArmRig rig;
  rig.bus.drive(4).refused_values[0x605A00] = 6;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  EXPECT_EQ(rig.bus.drive(4).object(0x605A, 0), 2u);
  EXPECT_FALSE(rig.loop->master().node(3).canopen()->stays_powered_on_quick_stop());
}

TEST(BringUp, SendsShorterSetPointsToADriveWithoutTorqueOffset) {
  ArmRig rig;
  rig.bus.drive(1).missing.insert(0x160003);
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.bus.sent.clear();
  rig.cycle();
  for (const CanFrame& frame : rig.bus.sent)
    if (frame.id == kRpdo1Base + 1) {
      EXPECT_EQ(frame.size, 6);
    }
  EXPECT_EQ(rig.bus.drive(1).object(0x1600, 0), 2u);
}

TEST(BringUp, AsksADriveWhoseHeartbeatIsOff) {
  ArmRig rig;
  rig.bus.drive(5).sends_heartbeat = false;
  EXPECT_TRUE(rig.cycle_until([&] { return rig.bus.drive(5).nmt == NmtState::kOperational; }, 1000));
}

TEST(BringUp, RefusesAnEncoderOffByAWholeTurn) {
  ArmRig rig;
  rig.bus.drive(4).position_counts += 32768.0;
  ASSERT_TRUE(rig.bring_to(Mode::kFault));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kOutsideLimits);
}

TEST(Enable, GoesThroughEveryStateWithTheTargetAtTheActualPosition) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  const double before = rig.bus.drive(4).position_counts;
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kHold));
  const std::vector<std::uint16_t> expected{kShutdown, kSwitchOn, kEnableOperation};
  EXPECT_EQ(rig.bus.drive(4).controlwords, expected);
  rig.cycles(100);
  EXPECT_NEAR(rig.bus.drive(4).position_counts, before, 1.0);  // moved by less than a count
}

TEST(Enable, NamesADriveThatDoesNotEnable) {
  ArmRig rig;
  rig.bus.drive(3).reaches_enabled = false;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 100));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kEnableTimeout);
  EXPECT_EQ(rig.state.fault.node, 3);
}

TEST(Enable, NamesADriveThatIgnoresItsTarget) {
  ArmRig rig;
  rig.bus.drive(3).heeds_target = false;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.order_mode(PowerWish::kHold);
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 200));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kTargetIgnored);
}

TEST(Supervision, BridgesTwoMissingSamplesAndStopsAtTheThird) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(2).sends_feedback = false;
  rig.cycles(3);
  EXPECT_EQ(rig.state.mode, Mode::kHold);
  rig.cycles(1);
  EXPECT_EQ(rig.state.mode, Mode::kFault);
  EXPECT_EQ(rig.state.fault.code, FaultCode::kFeedbackMissing);
  EXPECT_EQ(fault_text(rig.state.fault), "node 2: third TPDO1 in a row missing, last seen 12.0 ms ago");
  rig.cycles(3);
  EXPECT_EQ(rig.bus.drive(1).state, DriveState::kQuickStopActive);  // the others stop together, powered
}

TEST(Supervision, NamesALostHeartbeat) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(6).sends_heartbeat = false;
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 70));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kHeartbeatLost);
}

TEST(Supervision, ADriveFaultNeedsAnExplicitCommandAndARisingEdge) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(1).fail(0x2310);
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 10));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kDriveFault);
  rig.order_mode(PowerWish::kHold);
  rig.cycles(200);
  EXPECT_EQ(rig.state.mode, Mode::kFault);
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
  rig.order_mode(PowerWish::kHold, true);
  EXPECT_TRUE(rig.bring_to(Mode::kHold, 300)) << to_text(rig.state.mode) << fault_text(rig.state.fault);
}

TEST(Supervision, AnEncoderJumpStopsTheArm) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(2).position_counts += 2000;
  rig.bus.drive(2).follow_per_cycle = 0.0;
  rig.cycles(3);
  EXPECT_EQ(rig.state.fault.code, FaultCode::kEncoderStep);
}

TEST(Supervision, SetPointsThatFindNoRoomAreDroppedAndNamed) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.is_full = true;
  rig.cycles(5);
  EXPECT_EQ(rig.state.mode, Mode::kFault);
  EXPECT_EQ(rig.state.fault.code, FaultCode::kSendFailed);
}

TEST(Supervision, ADriveFaultIsToldWithStateCodeAndRegister) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(1).fail(0x2310);
  rig.bus.inject(encode(Emcy{0x2310, 0x03}, 1));
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 10));
  EXPECT_EQ(fault_text(rig.state.fault),
            "node 1: drive fault, fault (statusword 0x0008), last emergency 0x2310: over-current (error register: "
            "generic, current)");
  EXPECT_STREQ(fault_side(rig.state.fault.code), "drive");
}

TEST(Supervision, AnEmergencyStormStopsTheArmAndOneEmergencyDoesNot) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.inject(encode(Emcy{0x8140, 0x11}, 3));
  rig.cycles(20);
  EXPECT_EQ(rig.state.mode, Mode::kHold);
  for (int i = 0; i < 50; ++i) rig.bus.inject(encode(Emcy{0x4310, 0x09}, 3));
  rig.cycles(1);
  EXPECT_EQ(rig.state.fault.code, FaultCode::kEmergencyStorm);
  EXPECT_EQ(rig.state.fault.node, 3);
}

TEST(Supervision, ALostBusIsAFault) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.errors.lost = true;
  rig.cycles(1);
  EXPECT_EQ(rig.state.fault.code, FaultCode::kBusLost);
}

TEST(BringUp, NamesCountsThatNoFigureOfTheReportHolds) {
  ArmRig rig;
  rig.bus.drive(2).stuck[0x608F01] = rig.bus.drive(2).stuck[0x609101] = 0xFFFFFFFF;
  ASSERT_TRUE(rig.bring_to(Mode::kFault));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kWrongIdentity);
  EXPECT_EQ(rig.state.fault.detail, 0xFFFFFFFF);
}

}  // namespace
}  // namespace armsight::arm::test
