// Both programs and the simulated arm on the machine's own clock, with deadlines wide enough for a shared machine.
#pragma once

#include <csignal>
#include <string>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {

class RealPace : public SystemTest {
 protected:
  RealPace() {
    DemoOptions options = quiet_robot();
    options.pace = "real";
    const std::filesystem::path patient = robot_file("patient.yaml");
    write_patient_robot(options.robot_file, patient);
    options.robot_file = patient;
    start(options);
  }

  /// In the middle of a slow move: 0.2 rad/s for several seconds. Under way when joint 3's encoder says so on the bus.
  void start_moving_slowly(const std::vector<std::string>& host_command) {
    const std::int32_t begin = newest_position();
    conductor().start("host", host_command);
    const auto is_under_way = [&] { return std::abs(newest_position() - begin) > kUnderWay_counts; };
    for (int i = 0; i < 400 && !is_under_way() && !conductor().find("host")->exit_code(); ++i)
      conductor().run_cycles(10);
    ASSERT_TRUE(is_under_way()) << conductor().find("host")->last_lines();
    ASSERT_FALSE(conductor().find("host")->exit_code()) << conductor().find("host")->last_lines();
  }
  /// Of joint 3, as its drive told last.
  std::int32_t newest_position() const {
    const std::vector<CandumpLine> lines = read_bus_log(folder_);
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      if (const auto sample = decode_tpdo1(line->frame, 3)) return sample->position_counts;
    return 0;
  }
  static constexpr std::int32_t kUnderWay_counts = 500;  ///< 0.1 rad

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
