// Row 4: a node dies, boots late or never, has another's number, is another device, or cries without end.
// The others stop together, nothing moves in part, and the error has a name.
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;
using arm::FaultCode;

/// A motor that stands; of the twin.
struct StandingMotor : sim::Motor {
  std::int32_t position_counts() override { return 12'345; }
  std::int16_t torque_permille() const override { return 0; }
  void command(sim::MotorMode, std::int32_t, std::uint16_t) override {}
  std::uint32_t counts_per_turn() const override { return 32768; }
  std::uint32_t following_window_counts() const override { return 0; }
};

class FailingNode : public ::testing::Test {
 protected:
  FaultRig rig;

  /// All but `failed` left operation within `in`, in the same millisecond, and stay where they stopped, powered.
  void expect_others_stop_together(int failed, Time since, Duration in) {
    std::vector<Time> left;
    for (int node = 1; node <= kNodes; ++node) {
      if (node == failed) continue;
      const auto time = rig.left(node, DriveState::kOperationEnabled, since);
      ASSERT_TRUE(time) << "drive " << node << " goes on";
      left.push_back(*time);
      EXPECT_EQ(rig.drive(node), DriveState::kQuickStopActive) << "drive " << node;
    }
    const auto [first, last] = std::ranges::minmax(left);
    EXPECT_LE(last - first, 1ms);
    EXPECT_LE(first - since, in);
    EXPECT_EQ(rig.fastest_rad_s(), 0.0);
  }
  void expect_nothing_is_ever_enabled(int cycles) { expect_nothing_is_ever_enabled(rig, cycles); }
  static void expect_nothing_is_ever_enabled(FaultRig& rig, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      rig.cycle();
      if (i % 50 == 0) rig.order_mode(arm::PowerWish::kHold);
      ASSERT_TRUE(rig.no_drive(DriveState::kOperationEnabled)) << "cycle " << i;
    }
  }
};

TEST_F(FailingNode, DeadUnderWayStopsTheOthersTogether) {
  ASSERT_TRUE(rig.start_moving());
  const Time died = rig.now;
  rig.node(3).power_off(rig.now);
  rig.cycles(100);
  expect_others_stop_together(3, died, 6 * rig.period());
  EXPECT_EQ(rig.named(), FaultCode::kFeedbackMissing);
}

TEST_F(FailingNode, RebootedUnderWayStopsTheOthersTogether) {
  ASSERT_TRUE(rig.start_moving());
  const Time died = rig.now;
  rig.node(2).power_off(rig.now);
  rig.node(2).power_on(rig.now);
  rig.cycles(100);
  expect_others_stop_together(2, died, 4 * rig.period());
  EXPECT_EQ(rig.named(), FaultCode::kNodeRestarted);
}

TEST_F(FailingNode, LateIsWaitedFor) {
  FaultRig one(shipped_robot(), 4);
  expect_nothing_is_ever_enabled(one, 250);
  one.node(4).power_on(one.now);
  EXPECT_TRUE(one.power_up());
}

TEST_F(FailingNode, AbsentKeepsTheOthersOff) {
  FaultRig one(shipped_robot(), 4);
  expect_nothing_is_ever_enabled(one, 1000);
  EXPECT_EQ(one.named(), FaultCode::kNodeAbsent);
  EXPECT_EQ(one.state.fault.node, 4);
}

TEST_F(FailingNode, OfAnotherProfileIsNeverEnabled) {
  rig.node(2).bend({0x1000, 0}, 0x00020191);  // a generic I/O device
  expect_nothing_is_ever_enabled(500);
  EXPECT_EQ(rig.named(), FaultCode::kWrongIdentity);
  EXPECT_EQ(rig.state.fault.node, 2);
}

TEST_F(FailingNode, TwiceOnTheBusIsNeverEnabled) {
  StandingMotor motor;
  int port = 0;
  sim::DriveNode twin(2, [&](const CanFrame& frame, Time time) { rig.bus->send(port, frame, time); }, motor);
  port = rig.bus->add_port([&](const CanFrame& frame, Time end, bool is_own) {
    if (!is_own) twin.on_frame(frame, end);
  });
  twin.power_on(rig.now);
  expect_nothing_is_ever_enabled(1000);
  EXPECT_GE(rig.bus->error_frames(), 32U) << "one identifier, two voices: neither gets through";
  EXPECT_NE(rig.named(), FaultCode::kNone);
  EXPECT_EQ(rig.state.fault.node, 2);
  rig.bus->remove_port(port);
}

TEST_F(FailingNode, CryingWithoutEndStopsTheOthersTogether) {
  ASSERT_TRUE(rig.start_moving());
  const Time began = rig.now;
  for (int i = 0; i < 100; ++i) {
    rig.node(5).cry(0x4310, rig.now);
    rig.node(5).cry(0x4310, rig.now);
    rig.cycle();
  }
  expect_others_stop_together(5, began, 30 * rig.period());
  EXPECT_EQ(rig.named(), FaultCode::kEmergencyStorm);
}

}  // namespace
}  // namespace armsight::faults
