// Row 14: a controller starts and finds drives that are enabled already, holding, or with targets far from where they
// stand. Nothing moves by a count, and nothing that holds the arm is let go.
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

using enum DriveState;

class FoundEnabled : public ::testing::Test {
 protected:
  FaultRig rig;

  /// The arm stands somewhere after a motion, its controller is gone, every drive is in `state` with a target far away.
  static void leave_behind(FaultRig& rig, DriveState state) {
    ASSERT_TRUE(rig.start_moving());
    rig.kill_controller();
    rig.cycles(250);
    const int stranger = rig.bus->add_port([](const CanFrame&, Time, bool) {});
    for (std::uint8_t node = 1; node <= kNodes; ++node) {
      if (state != kQuickStopActive) rig.node(node).force(state);
      rig.bus->send(stranger, encode(SdoWrite{{0x607A, 0}, 1500, 4}, node), rig.now);
    }
    rig.cycles(5);
    rig.bus->remove_port(stranger);
  }
  static void expect_no_motion(FaultRig& rig) {
    const Time started = rig.now;
    rig.start_controller();
    ASSERT_TRUE(rig.power_up());
    rig.cycles(250);
    EXPECT_LT(rig.travelled_rad(started), kCount_rad);
  }
};

TEST_F(FoundEnabled, MovesLessThanACount) {
  leave_behind(rig, kOperationEnabled);
  expect_no_motion(rig);
}

TEST_F(FoundEnabled, InEveryOtherPoweredStateMovesLessThanACount) {
  for (const DriveState state : {kQuickStopActive, kSwitchedOn, kReadyToSwitchOn}) {
    FaultRig one;
    leave_behind(one, state);
    expect_no_motion(one);
  }
}

TEST_F(FoundEnabled, HoldingDrivesAreNotLetGo) {
  leave_behind(rig, kQuickStopActive);
  const Time started = rig.now;
  rig.start_controller();
  ASSERT_TRUE(rig.cycle_until([&] { return rig.is_configured(); }, 2000));
  rig.cycles(500);
  for (int node = 1; node <= kNodes; ++node)
    EXPECT_FALSE(rig.left(node, kQuickStopActive, started)) << "drive " << node << " let the arm go";
}

TEST_F(FoundEnabled, EveryTargetIsTheActualPositionUntilTheDriveIsEnabled) {
  leave_behind(rig, kOperationEnabled);
  const std::size_t before = rig.log.size();
  rig.start_controller();
  ASSERT_TRUE(rig.power_up());
  std::array<std::optional<std::int32_t>, kNodes + 1> position;
  std::array<bool, kNodes + 1> is_enabled{};
  for (std::size_t i = before; i < rig.log.size(); ++i)
    for (std::uint8_t node = 1; node <= kJoints; ++node) {
      const CanFrame& frame = rig.log[i].frame;
      if (const auto sample = decode_tpdo1(frame, node)) {
        position[node] = sample->position_counts;
        is_enabled[node] = drive_state(sample->statusword) == kOperationEnabled;
      }
      const auto command = decode_rpdo1(frame, node);
      if (!command || !position[node] || is_enabled[node]) continue;
      ASSERT_LE(std::abs(command->target_counts - *position[node]), 1) << "drive " << int{node};
    }
}

}  // namespace
}  // namespace armsight::faults
