// Only here: programs that stand still and a cable that goes dead, at real pace: nothing is closed, nobody says
// goodbye. What the arm did is judged by the simulator's truth and its log of the bus.
#include <algorithm>

#include "tests/system/real_pace_rig.hpp"
#include "tests/system/stalling_relay.hpp"

namespace armsight::demo {
namespace {

constexpr double kStill_rad_s = 0.02;

class RealPaceLoss : public RealPace {
 protected:
  /// Exit code of the host, once it has ended by itself.
  int wait_for_host() {
    for (int i = 0; i < 100 && !conductor().find("host")->exit_code(); ++i) conductor().run_cycles(25);
    if (!conductor().find("host")->exit_code()) ADD_FAILURE() << "the host has not noticed within 10 s";
    return conductor().find("host")->exit_code().value_or(-1);
  }
  void expect_holding() {
    ASSERT_EQ(arm().host({"status"}), 0);
    EXPECT_NE(line_of("mode:").find("hold"), std::string::npos) << line_of("mode:");
  }
  /// It was under way, came to rest short of its goal, and rests.
  static void expect_stopped_for_good(const Truth& truth) {
    std::size_t fast = 0;
    for (std::size_t row = 0; row + 1 < truth.rows.size(); ++row)
      if (speed_rad_s(truth, row) > 0.1) fast = row;
    ASSERT_GT(fast, 0U) << "the arm was never under way";
    ASSERT_GT(truth.rows.size(), fast + 60) << "the trace ends with the motion";
    for (std::size_t row = fast + 30; row + 1 < truth.rows.size(); ++row)
      ASSERT_LT(speed_rad_s(truth, row), kStill_rad_s);
    const double rest_rad = std::abs(truth.rows.back().q_reading(2) - (-1.35));
    EXPECT_GT(rest_rad, 0.2) << "it went on to its goal";
  }
};

TEST_F(RealPaceLoss, StoppedHostLosesItsLeaseAndMovesNothingWhenItGoesOn) {
  go_to_start();
  start_moving_slowly(arm().host_command(slow_move()));
  conductor().find("host")->send_signal(SIGSTOP);  // the connection stays open
  conductor().run_cycles(250);
  ChildProcess& stopped = *conductor().find("host");
  expect_holding();
  stopped.send_signal(SIGCONT);
  EXPECT_EQ(wait_for_host(), 1) << stopped.last_lines();
  expect_stopped_for_good(arm().finish());
}

TEST_F(RealPaceLoss, HalfOpenLinkEndsTheHostAndLeavesTheArmHolding) {
  go_to_start();
  std::vector<std::string> command = arm().host_command(slow_move());
  std::string& address = *(std::ranges::find(command, "--arm") + 1);
  StallingRelay relay(address);
  address = relay.address();
  start_moving_slowly(command);
  relay.stall();
  EXPECT_EQ(wait_for_host(), 3) << conductor().find("host")->last_lines();
  conductor().kill("host");
  expect_holding();
  expect_stopped_for_good(arm().finish());
}

TEST_F(RealPaceLoss, StoppedControllerEndsTheHostAndTheDrivesHoldByThemselves) {
  go_to_start();
  start_moving_slowly(arm().host_command(slow_move()));
  ChildProcess& controller = *conductor().find("arm_controller");
  controller.send_signal(SIGSTOP);
  EXPECT_EQ(wait_for_host(), 3) << conductor().find("host")->last_lines();
  controller.send_signal(SIGCONT);
  conductor().run_cycles(250);
  expect_stopped_for_good(arm().finish());
  EXPECT_GE(emergencies(), 5) << "each drive says why it stopped";
}

}  // namespace
}  // namespace armsight::demo
