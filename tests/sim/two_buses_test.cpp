// An arm on two buses: SYNC on both, a motion at 1 kHz, which one bus cannot carry, and the loss of one of them.
#include <gtest/gtest.h>

#include <map>

#include "protocol/bus_budget.hpp"
#include "protocol/bus_traffic.hpp"
#include "tests/sim/closed_loop.hpp"

namespace armsight::sim {
namespace {

/// Shoulder on bus 0, elbow, forearm and hand on bus 1.
RobotConfig two_bus_robot(double period_s) {
  RobotConfig robot = load_robot(ARMSIGHT_SOURCE_DIR "/arm_controller/config/ego_right_arm.yaml");
  robot.controller.period_s = period_s;
  robot.drives[3].bus = robot.drives[4].bus = robot.hand.bus = 1;
  return robot;
}

TEST(TwoBuses, CarryAMotionAtOneKilohertz) {
  ClosedLoop arm(two_bus_robot(0.001));
  ASSERT_EQ(broken_load_rule(arm.robot), "");
  ASSERT_TRUE(arm.power_up());
  std::vector<BusTraffic> traffic(2, BusTraffic(bus_rates(arm.robot)));
  arm.watch([&](std::size_t bus, const CanFrame& frame, Time end) { traffic[bus].add(frame, end); });
  const JointVector goal = arm.state.q_reading_rad + JointVector::Constant(5, 0.3);
  arm.move_to(goal);
  arm.cycles(2000);
  EXPECT_EQ(arm.state.mode, arm::Mode::kHold) << arm::fault_text(arm.state.fault);
  EXPECT_LT((arm.state.q_reading_rad - goal).cwiseAbs().maxCoeff(), arm.robot.controller.goal_tolerance_rad);
  const std::vector<BusBudget> budgets = bus_budgets(arm.robot);
  for (std::size_t bus = 0; bus < 2; ++bus) {
    EXPECT_NEAR(static_cast<double>(traffic[bus].messages().at(kSyncId).count), 2000, 2) << "bus " << bus;
    EXPECT_NEAR(traffic[bus].worst_case_load(), budgets[bus].load, 0.01) << "bus " << bus;
  }
  EXPECT_TRUE(traffic[0].messages().contains(kTpdo1Base + 3));
  EXPECT_FALSE(traffic[0].messages().contains(kTpdo1Base + 4)) << "that node is on the other bus";
  EXPECT_TRUE(traffic[1].messages().contains(kTpdo1Base + 4));
}

TEST(TwoBuses, BothHearTheControllersHeartbeat) {
  ClosedLoop arm(two_bus_robot(0.002));
  std::map<std::size_t, int> heartbeats;
  arm.watch([&](std::size_t bus, const CanFrame& frame, Time) {
    if (frame.id == kHeartbeatBase + kControllerNode) ++heartbeats[bus];
  });
  arm.cycles(500);
  EXPECT_NEAR(heartbeats[0], 10, 1);
  EXPECT_EQ(heartbeats[0], heartbeats[1]);
}

class LostBus : public testing::TestWithParam<std::size_t> {};

TEST_P(LostBus, IsAFaultThatNamesItAndStopsTheOther) {
  ClosedLoop arm(two_bus_robot(0.002));
  ASSERT_TRUE(arm.power_up());
  arm.move_to(arm.state.q_reading_rad + JointVector::Constant(5, 0.5));
  arm.cycles(200);
  ASSERT_EQ(arm.state.mode, arm::Mode::kServo);
  const std::size_t lost = GetParam();
  arm.cut(lost);
  arm.cycle();
  EXPECT_EQ(arm.state.mode, arm::Mode::kFault);
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kBusLost);
  EXPECT_EQ(arm::fault_text(arm.state.fault), "the CAN bus " + std::to_string(lost) + " is gone");
  EXPECT_FALSE(arm.loop().bus_is_lost()) << "one of two: the program stays and tells";
  arm.cycles(50);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(arm.world().node(i).state(), DriveState::kQuickStopActive) << "joint " << i;
  arm.cycles(200);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(arm.world().plant().speed_rad_s(i), 0.0) << "joint " << i;
}

INSTANTIATE_TEST_SUITE_P(Buses, LostBus, testing::Values(0u, 1u));

TEST(TwoBuses, BothLostEndTheProgram) {
  ClosedLoop arm(two_bus_robot(0.002));
  arm.cut(0);
  arm.cut(1);
  arm.cycle();
  EXPECT_TRUE(arm.loop().bus_is_lost());
}

TEST(TwoBuses, OneOfThemFullIsNamed) {
  ClosedLoop arm(two_bus_robot(0.002));
  ASSERT_TRUE(arm.power_up());
  arm.fill(1);
  arm.cycles(4);
  EXPECT_EQ(arm.state.fault.code, arm::FaultCode::kSendFailed);
  EXPECT_EQ(arm::fault_text(arm.state.fault), "set-points could not be sent on bus 1 in three cycles in a row");
}

}  // namespace
}  // namespace armsight::sim
