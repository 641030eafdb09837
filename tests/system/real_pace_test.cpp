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

TEST_F(RealPace, LearnsAndAdaptsThoughTheHostIsHeldUp) {
  conductor().start("host", arm().host_command({"calibrate", "--looks", "6"}));
  conductor().run_cycles(400);
  conductor().find("host")->send_signal(SIGSTOP);  // longer than the lease of 200 ms
  conductor().run_cycles(60);
  conductor().find("host")->send_signal(SIGCONT);
  // Sanitizers make it some times slower.
  for (int i = 0; i < 1000 && !conductor().find("host")->exit_code(); ++i) conductor().run_cycles(50);
  EXPECT_EQ(conductor().end("host"), 0);
  EXPECT_EQ(arm().host({"adapt", "--looks", "3"}), 0);
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "controller"))
    EXPECT_FALSE(entry.path().filename().string().starts_with("blackbox")) << "no fault: " << entry.path();
}

}  // namespace
}  // namespace armsight::demo
