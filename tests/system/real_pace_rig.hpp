// Both programs and the simulated arm on the machine's own clock, with deadlines wide enough for a shared machine.
#pragma once

#include <csignal>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {

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

  /// In the middle of a slow move: 0.2 rad/s for several seconds.
  void start_moving_slowly(const std::vector<std::string>& host_command) {
    conductor().start("host", host_command);
    conductor().run_cycles(400);
    ASSERT_FALSE(conductor().find("host")->exit_code()) << conductor().find("host")->last_lines();
  }
  void go_to_start() { ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0); }
  static std::vector<std::string> slow_move() {
    return {"move", "--joints=1.16,0.57,-1.35,0.67,-0.16", "--speed", "0.1"};
  }

  /// Of the latest host's words.
  std::string line_of(const std::string& start) {
    for (const std::string& line : arm().host_lines())
      if (line.starts_with(start)) return line;
    return {};
  }
};

}  // namespace armsight::demo
