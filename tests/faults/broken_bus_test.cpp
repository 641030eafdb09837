// Row 5: bus-off, error passive, nobody acknowledges, no room to send. Found within a cycle, a whole start sequence
// after it, and not one stale set-point.
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;
using arm::FaultCode;

bool enables(const CanFrame& frame) {
  for (std::uint8_t node = 1; node <= kNodes; ++node)
    if (const auto command = decode_rpdo1(frame, node)) return (command->controlword & 0x0F) == kEnableOperation;
  return false;
}

class BrokenBus : public ::testing::Test {
 protected:
  FaultRig rig;

  void SetUp() override { ASSERT_TRUE(rig.start_moving()); }

  void expect_all_stopped_by_themselves(Time since) {
    for (int node = 1; node <= kNodes; ++node) {
      const auto left = rig.left(node, DriveState::kOperationEnabled, since);
      ASSERT_TRUE(left) << "drive " << node << " goes on";
      EXPECT_LE(*left - since, 260ms) << "drive " << node << ": by the heartbeat at the latest";
    }
    EXPECT_TRUE(rig.all_drives(DriveState::kQuickStopActive));
    EXPECT_EQ(rig.fastest_rad_s(), 0.0);
  }
  /// Every node is taken to pre-operational, gets its PDOs anew, and only then is enabled again.
  void expect_whole_start_sequence(Time since) {
    for (std::uint8_t node = 1; node <= kNodes; ++node) {
      int step = 0;  // pre-operational, RPDO1 written, started, enabled
      for (const BusLine& line : rig.log) {
        if (line.time <= since) continue;
        const auto nmt = decode_nmt(line.frame);
        const auto write = decode_sdo_write(line.frame, node);
        const auto command = decode_rpdo1(line.frame, node);
        if (nmt && nmt->node == node && nmt->command == NmtCommand::kPreOperational) step = 1;
        if (write && write->object == ObjectAddress{0x1400, 1} && step == 1) step = 2;
        if (nmt && nmt->node == node && nmt->command == NmtCommand::kStart && step == 2) step = 3;
        if (command && (command->controlword & 0x0F) == kEnableOperation) {
          EXPECT_EQ(step, 3) << "drive " << int{node} << " was enabled without it";
          break;
        }
      }
      EXPECT_EQ(step, 3) << "drive " << int{node};
    }
  }
  void expect_comes_back_without_a_jump() {
    const Time cleared = rig.now;
    rig.order_mode(arm::PowerWish::kHold, true);
    ASSERT_TRUE(rig.cycle_until([&] { return rig.all_drives(DriveState::kOperationEnabled); }, 1000));
    rig.cycles(100);
    EXPECT_LT(rig.travelled_rad(cleared), kCount_rad);
    expect_whole_start_sequence(cleared);
  }
};

TEST_F(BrokenBus, BusOffStopsTheDrivesAndNeedsTheWholeStartSequence) {
  const Time off = rig.now;
  rig.bus->force_bus_off(rig.controller_port(), rig.now);
  rig.cycle();
  rig.cycle();
  EXPECT_EQ(rig.named(), FaultCode::kBusOff) << "within a cycle";
  rig.cycles(250);
  EXPECT_EQ(rig.bus->state(rig.controller_port()), sim::PortState::kErrorActive) << "restart-ms is over";
  expect_all_stopped_by_themselves(off);
  EXPECT_EQ(rig.count(off, enables), 0) << "stale set-points";
  expect_comes_back_without_a_jump();
}

TEST_F(BrokenBus, BitErrorsLeadOverErrorPassiveToBusOff) {
  const std::uint32_t id = kRpdo1Base + 1;
  rig.bus->set_judge([&](const CanFrame& frame, Time) { return sim::Passage{.is_destroyed = frame.id == id}; });
  const Time began = rig.now;
  rig.cycles(3);
  rig.bus->set_judge({});
  rig.cycles(250);
  EXPECT_GE(rig.bus->error_frames(), 32U);
  expect_all_stopped_by_themselves(began);
  EXPECT_EQ(rig.named(), FaultCode::kBusOff);
}

TEST_F(BrokenBus, ErrorPassiveIsCarried) {
  int destroyed = 0;
  rig.bus->set_judge([&](const CanFrame& frame, Time) {
    return sim::Passage{.is_destroyed = frame.id == kRpdo1Base + 2 && ++destroyed <= 17};
  });
  rig.cycle();
  EXPECT_EQ(rig.bus->state(rig.controller_port()), sim::PortState::kErrorPassive);
  rig.cycles(100);
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
  EXPECT_GT(rig.fastest_rad_s(), 0.4);
}

TEST_F(BrokenBus, CableUnpluggedAndPluggedInMovesNothing) {
  const Time cut = rig.now;
  rig.bus->set_connected(rig.controller_port(), false);
  rig.cycles(100);
  expect_all_stopped_by_themselves(cut);
  const Time back = rig.now;
  rig.bus->set_connected(rig.controller_port(), true);
  rig.cycles(250);
  EXPECT_TRUE(rig.no_drive(DriveState::kOperationEnabled));
  EXPECT_LT(rig.travelled_rad(back), kCount_rad);
  EXPECT_NE(rig.named(), FaultCode::kNone);
}

TEST_F(BrokenBus, SomebodyWhoTalksAllTheTimeStopsTheDrivesAndNothingFollows) {
  const int babbler = rig.bus->add_port([](const CanFrame&, Time, bool) {});
  const CanFrame loud{0x001, 8, {}};
  const Time began = rig.now;
  for (int i = 0; i < 75; ++i) {
    while (rig.bus->send(babbler, loud, rig.now)) {
    }
    rig.cycle();
  }
  rig.cycles(5);
  expect_all_stopped_by_themselves(began);
  const Time quiet = rig.now;
  rig.cycles(250);
  EXPECT_TRUE(rig.no_drive(DriveState::kOperationEnabled));
  EXPECT_LT(rig.travelled_rad(quiet), kCount_rad);
}

}  // namespace
}  // namespace armsight::faults
