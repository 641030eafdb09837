// Row 3: the controller is killed. The drives must stop by themselves, and a new controller must not move them.

#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;

class LostController : public ::testing::Test {
 protected:
  FaultRig rig;

  Time last_frame(std::uint32_t id) const {
    Time last{};
    for (const BusLine& line : rig.log)
      if (line.frame.id == id) last = line.time;
    return last;
  }
};

TEST_F(LostController, DrivesStartTheirQuickStopWithin20MillisecondsOfTheLastSetPoint) {
  ASSERT_TRUE(rig.start_moving());
  const Time killed = rig.now;
  rig.kill_controller();
  rig.cycles(100);
  for (std::uint8_t node = 1; node <= kNodes; ++node) {
    const auto left = rig.left(node, DriveState::kOperationEnabled, killed);
    ASSERT_TRUE(left) << "drive " << int{node} << " goes on";
    EXPECT_LE(*left - last_frame(kRpdo1Base + node), 20ms) << "drive " << int{node};
    EXPECT_EQ(rig.drive(node), DriveState::kQuickStopActive) << "still powered";
  }
  EXPECT_EQ(rig.fastest_rad_s(), 0.0);
  EXPECT_LT(rig.travelled_rad(killed), 0.5 * (0.020 + 0.025) + 0.5 * 0.5 / (2 * 20.0)) << "deadline, lag, ramp";
}

TEST_F(LostController, DrivesWithoutADeadlineStopWithin250MillisecondsByTheHeartbeat) {
  for (int node = 1; node <= kNodes; ++node) rig.node(node).bend({0x1400, 5}, std::nullopt);
  ASSERT_TRUE(rig.start_moving());
  const Time killed = rig.now;
  rig.kill_controller();
  rig.cycles(100);
  for (int node = 1; node <= kNodes; ++node) {
    const auto left = rig.left(node, DriveState::kOperationEnabled, killed);
    ASSERT_TRUE(left) << "drive " << node << " goes on";
    EXPECT_LE(*left - killed, 250ms) << "drive " << node;
  }
  EXPECT_TRUE(rig.all_drives(DriveState::kQuickStopActive));
}

TEST_F(LostController, ItsSuccessorFindsTargetsPresetAndMovesNothing) {
  ASSERT_TRUE(rig.start_moving());
  rig.kill_controller();
  rig.cycles(250);
  const Time restarted = rig.now;
  rig.start_controller();
  ASSERT_TRUE(rig.power_up());
  rig.cycles(250);
  EXPECT_LT(rig.travelled_rad(restarted), kCount_rad);
  rig.send_goal(FaultRig::posture(0.3, 0, 0, 1, 0));
  rig.cycles(100);
  EXPECT_GT(rig.fastest_rad_s(), 0.1) << "it can move again";
}

}  // namespace
}  // namespace armsight::faults
