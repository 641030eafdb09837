// Row 12: every CiA 402 state in every situation; a fault at every moment of enabling; a mode changed behind our back.
// Each ends in bounded time with all drives enabled or none, and a way back. The table itself: drive_commands_test.
#include "arm_controller/drive_commands.hpp"
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

using enum DriveState;
constexpr DriveState kStates[] = {kSwitchOnDisabled, kReadyToSwitchOn, kSwitchedOn, kOperationEnabled, kQuickStopActive,
                                  kFault};

class DriveInAnyState : public ::testing::Test {
 protected:
  static bool is_settled(const FaultRig& rig) {
    return rig.all_drives(kOperationEnabled) || (rig.no_drive(kOperationEnabled) && rig.fastest_rad_s() == 0.0);
  }
  static void expect_settles_and_comes_back(FaultRig& rig, const std::string& what) {
    ASSERT_TRUE(rig.cycle_until([&] { return is_settled(rig); }, 200)) << what << ": neither all nor none after 0.8 s";
    rig.cycles(100);
    ASSERT_TRUE(is_settled(rig)) << what;
    if (rig.named() == arm::FaultCode::kNone && !rig.all_drives(kOperationEnabled)) rig.cycles(100);
    if (rig.all_drives(kOperationEnabled)) return;
    const bool has_name = rig.named() != arm::FaultCode::kNone || rig.state.mode == arm::Mode::kReady;
    ASSERT_TRUE(has_name) << what << ": stands without a reason";
    rig.order_mode(arm::PowerWish::kHold, true);
    EXPECT_TRUE(rig.cycle_until([&] { return rig.all_drives(kOperationEnabled); }, 1500)) << what << ": no way back";
  }
};

TEST_F(DriveInAnyState, WhileTheArmMovesStopsAllOrNone) {
  for (const DriveState state : kStates) {
    FaultRig rig;
    ASSERT_TRUE(rig.start_moving());
    if (state == kFault) rig.node(3).fail(0x2310, rig.now);
    else rig.node(3).force(state);
    rig.cycles(3);
    expect_settles_and_comes_back(rig, to_text(state));
  }
}

TEST_F(DriveInAnyState, WhileTheArmIsUnpoweredIsBroughtToOperation) {
  for (const DriveState state : kStates) {
    FaultRig rig;
    ASSERT_TRUE(rig.cycle_until([&] { return rig.is_configured(); }, 2000));
    if (state == kFault) rig.node(3).fail(0x2310, rig.now);
    else rig.node(3).force(state);
    rig.cycles(10);
    rig.order_mode(arm::PowerWish::kHold, true);
    rig.cycles(10);
    expect_settles_and_comes_back(rig, to_text(state));
  }
}

TEST_F(DriveInAnyState, AFaultAtAnyMomentOfEnablingLeavesNoneEnabledAndCanBeCleared) {
  for (int moment = 0; moment < 24; ++moment) {
    FaultRig rig;
    ASSERT_TRUE(rig.cycle_until([&] { return rig.is_configured(); }, 2000));
    rig.order_mode(arm::PowerWish::kHold);
    rig.cycles(moment);
    rig.node(2).fail(0x3210, rig.now);
    rig.cycles(3);
    const std::string what = "cycle " + std::to_string(moment);
    ASSERT_TRUE(rig.cycle_until([&] { return rig.no_drive(kOperationEnabled); }, 75)) << what;
    expect_settles_and_comes_back(rig, what);
  }
}

TEST_F(DriveInAnyState, ADriveThatIsNeverEnabledTakesPowerFromTheOthersInBoundedTime) {
  FaultRig rig;
  rig.node(4).hold_back(true);
  ASSERT_TRUE(rig.cycle_until([&] { return rig.is_configured(); }, 2000));
  rig.order_mode(arm::PowerWish::kHold);
  ASSERT_TRUE(rig.cycle_until([&] { return rig.drive(1) == kOperationEnabled; }, 50));
  EXPECT_TRUE(rig.cycle_until([&] { return rig.no_drive(kOperationEnabled); }, 75)) << "300 ms";
  rig.node(4).hold_back(false);
  rig.order_mode(arm::PowerWish::kHold, true);
  EXPECT_TRUE(rig.cycle_until([&] { return rig.all_drives(kOperationEnabled); }, 500));
}

TEST_F(DriveInAnyState, AModeChangedBehindOurBackStopsTheOthers) {
  FaultRig rig;
  ASSERT_TRUE(rig.start_moving());
  const int stranger = rig.bus->add_port([](const CanFrame&, Time, bool) {});
  rig.bus->send(stranger, encode(SdoWrite{{0x6060, 0}, 6, 1}, 3), rig.now);  // homing
  rig.cycles(75);
  for (const int other : {1, 2, 4, 5, 6}) EXPECT_EQ(rig.drive(other), kQuickStopActive) << other;
  EXPECT_EQ(rig.fastest_rad_s(), 0.0);
}

}  // namespace
}  // namespace armsight::faults
