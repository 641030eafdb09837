// Only here: link, camera, goals, stop and recording all active on the machine's own clock; what TSan watches.
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class RealPace : public SystemTest {
 protected:
  RealPace() {
    DemoOptions options = quiet_robot();
    options.pace = "real";
    options.robot_file = patient_robot(options.robot_file);
    start(options);
  }

  /// The demo's robot at 100 Hz with wide deadlines: a shared machine stalls a program for 10–20 ms now and then, and
  /// what is tested here is the hand-over between threads and programs, not the machine.
  std::filesystem::path patient_robot(const std::filesystem::path& nominal) const {
    std::ifstream in(nominal);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto set = [&](const std::string& from, const std::string& to) {
      text.replace(text.find(from), from.size(), to);
    };
    set("period_s: 0.004", "period_s: 0.01");
    set("rpdo_deadline_s: 0.02", "rpdo_deadline_s: 0.2");
    const std::filesystem::path file = folder_.string() + "-patient_robot.yaml";
    std::ofstream(file) << text;
    return file;
  }

  /// Of the latest host's words.
  std::string line_of(const std::string& start) {
    for (const std::string& line : arm().host_lines())
      if (line.starts_with(start)) return line;
    return {};
  }
};

TEST_F(RealPace, MovesLooksStopsAndRecords) {
  ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
  conductor().start("host", arm().host_command({"move", "--joints=1.16,0.57,-1.35,0.67,-0.16", "--speed", "0.1"}));
  conductor().run_cycles(400);
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
  for (int i = 0; i < 300 && !conductor().find("host")->exit_code(); ++i) conductor().run_cycles(50);
  EXPECT_EQ(conductor().end("host"), 0);
  EXPECT_EQ(arm().host({"adapt", "--looks", "3"}), 0);
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "controller"))
    EXPECT_FALSE(entry.path().filename().string().starts_with("blackbox")) << "no fault: " << entry.path();
}

TEST_F(RealPace, StoppedHostLosesItsLease) {
  ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
  conductor().start("host", arm().host_command({"move", "--joints=1.16,0.57,-1.35,0.67,-0.16", "--speed", "0.1"}));
  conductor().run_cycles(400);
  conductor().find("host")->send_signal(SIGSTOP);  // the connection stays open
  conductor().run_cycles(250);
  ASSERT_EQ(arm().host({"status"}), 0);
  EXPECT_NE(line_of("mode:").find("hold"), std::string::npos) << line_of("mode:");
  conductor().kill("host");
}

}  // namespace
}  // namespace armsight::demo
