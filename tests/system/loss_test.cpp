// Only here: what the arm does when a whole program is gone, judged by the simulator's truth and the bus alone.
#include <algorithm>
#include <csignal>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class LossOfAProgram : public SystemTest {};

TEST_F(LossOfAProgram, KilledHostLeavesTheArmStillAndPoweredWithin200MillisecondsAndBraking) {
  start(quiet_robot());
  start_moving();
  const double killed_s = conductor().time_s();
  conductor().kill("host");
  conductor().run_cycles(250);
  ASSERT_EQ(arm().host({"status"}), 0);
  const auto mode =
      std::ranges::find_if(arm().host_lines(), [](const std::string& l) { return l.starts_with("mode:"); });
  ASSERT_NE(mode, arm().host_lines().end());
  EXPECT_NE(mode->find("hold"), std::string::npos) << "powered and holding is mode HOLD, not: " << *mode;
  EXPECT_NE(mode->find("still"), std::string::npos) << *mode;

  const double finished_s = conductor().time_s();
  const Truth truth = arm().finish();
  const auto at = [&](double after_kill_s) {
    const double before_end_s = finished_s - killed_s - after_kill_s;
    return truth.rows.size() - 3 - static_cast<std::size_t>(std::lround(before_end_s / 0.004));
  };
  EXPECT_GT(speed_rad_s(truth, at(-0.02)), 0.3) << "the arm was not under way";
  constexpr double kBraking_s =
      0.6 / 10.0 + 10.0 / 200.0 + 0.05;  // speed, acceleration, jerk of the demo's robot; the drive's lag
  for (std::size_t row = at(0.2 + kBraking_s); row + 1 < truth.rows.size(); ++row) {
    ASSERT_LT(speed_rad_s(truth, row), 0.02)
        << "still moving " << 0.004 * static_cast<double>(row - at(0.0)) << " s after the kill";
  }
}

TEST_F(LossOfAProgram, KilledControllerMakesTheDrivesStopByThemselves) {
  start(quiet_robot());
  start_moving();
  conductor().kill("arm_controller");
  conductor().run_cycles(250);
  arm().start_controller();
  conductor().run_cycles(1000);

  const Truth truth = arm().finish();
  std::size_t gap = 0;  // no controller, no SYNC, no rows
  for (std::size_t row = 0; row + 1 < truth.rows.size(); ++row) {
    if (truth.rows[row + 1].arm_time_ns - truth.rows[row].arm_time_ns > 500'000'000) gap = row;
  }
  ASSERT_GT(gap, 10u) << "the trace shows no time without a controller";
  EXPECT_GT(speed_rad_s(truth, gap - 2), 0.3) << "the arm was not under way";
  const double drifted_rad = (truth.rows[gap + 1].q_true - truth.rows[gap].q_true).cwiseAbs().maxCoeff();
  EXPECT_LT(drifted_rad, 0.6 * 0.05 + 0.6 * 0.6 / (2 * 5.0)) << "20 ms of deadline, then a quick stop";
  for (std::size_t row = gap + 1; row < gap + 10; ++row) EXPECT_LT(speed_rad_s(truth, row), 0.02);

  EXPECT_GE(emergencies(), 5) << "each drive says why it stopped";
}

}  // namespace
}  // namespace armsight::demo
