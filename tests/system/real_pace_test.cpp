// Only here: link, camera, goals, stop and recording all active on the machine's own clock; what TSan watches.
#include "tests/system/real_pace_rig.hpp"

namespace armsight::demo {
namespace {

TEST_F(RealPace, MovesLooksStopsAndRecords) {
  go_to_start();
  start_moving_slowly(arm().host_command(slow_move()));
  EXPECT_EQ(arm().host({"stop"}), 0) << "stop is taken from anybody";
  EXPECT_EQ(conductor().end("host"), 1) << "a move that was stopped did not arrive";
  conductor().run_cycles(100);
  EXPECT_EQ(arm().host({"status"}), 0);
  const std::string before = line_of("joints:");
  conductor().run_cycles(100);
  EXPECT_EQ(arm().host({"status"}), 0);
  EXPECT_EQ(line_of("joints:"), before) << "the arm stands";
  EXPECT_GT(std::filesystem::file_size(folder_ / "controller/ticks.mcap"), 100'000U) << "6 s of ticks";
}

/// The program stands still for longer than the lease of 200 ms.
void hold_up(ChildProcess& host, Conductor& conductor) {
  host.send_signal(SIGSTOP);
  conductor.run_cycles(60);
  host.send_signal(SIGCONT);
}

/// Until it says so, or ends. Sanitizers make it some times slower.
bool has_said(ChildProcess& host, Conductor& conductor, const std::string& line) {
  for (int i = 0; i < 1000 && !host.line_after(line) && !host.exit_code(); ++i) conductor.run_cycles(50);
  return host.line_after(line).has_value();
}
int exit_code_of(ChildProcess& host, Conductor& conductor) {
  has_said(host, conductor, "a line that it never says");
  return host.exit_code().value_or(-1);
}

TEST_F(RealPace, LearnsAndAdaptsThoughTheHostIsHeldUp) {
  ChildProcess& learning = conductor().start("host", arm().host_command({"calibrate", "--looks", "6"}));
  conductor().run_cycles(400);
  hold_up(learning, conductor());
  EXPECT_EQ(exit_code_of(learning, conductor()), 0) << learning.last_lines();
  ChildProcess& adapting = conductor().start("host", arm().host_command({"adapt", "--looks", "3"}));
  ASSERT_TRUE(has_said(adapting, conductor(), "look 1/3")) << adapting.last_lines();
  hold_up(adapting, conductor());  // the lost lease closes the recalibration
  EXPECT_EQ(exit_code_of(adapting, conductor()), 0) << adapting.last_lines();
  EXPECT_TRUE(adapting.line_after("look 3/3: fused")) << adapting.last_lines();
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "controller"))
    EXPECT_FALSE(entry.path().filename().string().starts_with("blackbox")) << "no fault: " << entry.path();
}

}  // namespace
}  // namespace armsight::demo
