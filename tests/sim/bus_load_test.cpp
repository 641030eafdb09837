// What bus_budget predicts against what the emulated bus carries while the arm moves.
#include <gtest/gtest.h>

#include "protocol/bus_budget.hpp"
#include "protocol/bus_traffic.hpp"
#include "tests/sim/closed_loop.hpp"

namespace armsight::sim {
namespace {

RobotConfig robot_at(double period_s) {
  RobotConfig robot = load_robot(ARMSIGHT_SOURCE_DIR "/arm_controller/config/ego_right_arm.yaml");
  robot.controller.period_s = period_s;
  return robot;
}

class BusLoad : public testing::TestWithParam<double> {};

TEST_P(BusLoad, OfTheMovingArmIsWhatWasPredicted) {
  const double period_s = GetParam();
  ClosedLoop arm(robot_at(period_s));
  ASSERT_TRUE(arm.power_up());
  const auto two_s = static_cast<int>(2.0 / period_s);
  arm.move_to(arm.state.q_reading_rad + JointVector::Constant(5, 0.5));
  BusTraffic traffic(bus_rates(arm.robot));
  arm.watch([&](std::size_t, const CanFrame& frame, Time end) { traffic.add(frame, end); });
  const JointVector before = arm.state.q_reading_rad;
  arm.cycles(two_s);
  ASSERT_GT((arm.state.q_reading_rad - before).minCoeff(), 0.4) << "it did not move";

  const BusBudget budget = bus_budgets(arm.robot).front();
  // All but the allowance for SDO and EMCY, of which a moving arm needs none.
  const double allowance = (20 * 2 * 135 + 5 * 135) / 1e6;
  // The emulated bus stuffs as often as it can.
  EXPECT_NEAR(traffic.worst_case_load(), budget.load - allowance, 0.002);
  EXPECT_LT(traffic.load(), traffic.worst_case_load());
  EXPECT_GT(traffic.load(), 0.85 * traffic.worst_case_load());
  int cyclic = 0;
  for (const BusMessage& message : budget.messages) {
    if (!message.is_cyclic) continue;
    ++cyclic;
    const SeenMessage& seen = traffic.messages().at(message.id);
    EXPECT_NEAR(static_cast<double>(seen.count), two_s, 2) << message.name;
    EXPECT_LE(*seen.latest_s, *message.latest_s + 1e-9) << message.name << " came later than it can";
  }
  EXPECT_EQ(cyclic, 13);
}

INSTANTIATE_TEST_SUITE_P(Rates, BusLoad, testing::Values(0.004, 0.002));

}  // namespace
}  // namespace armsight::sim
