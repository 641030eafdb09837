// The simulated arm without noise and in the middle of a move, for tests and benchmarks of whole programs.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "protocol/candump.hpp"
#include "tools/report/demo_session.hpp"

namespace armsight::demo {

/// The demo's robot without noise; programs stand beside the test.
inline DemoOptions quiet_robot() {
  DemoOptions options;
  options.home = ARMSIGHT_HOME;
  options.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  options.robot_file = options.home / "tools/experiments/demo_robot.yaml";
  options.noise = "clean";
  return options;
}

/// The robot file with some of its text changed, written to `file`.
inline void write_changed_robot(const std::filesystem::path& robot, const std::filesystem::path& file,
                                const std::vector<std::pair<std::string, std::string>>& changes) {
  std::ifstream in(robot);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const auto& [from, to] : changes) {
    const std::size_t at = text.find(from);
    if (at == text.npos) throw std::runtime_error(robot.string() + " has no \"" + from + "\" to change");
    text.replace(at, from.size(), to);
  }
  std::ofstream(file) << text;
}

/// The robot at 100 Hz with wide deadlines, for real pace: a shared machine stalls a program for 10–20 ms now and then,
/// and what is looked at is the hand-over between threads and programs, not the machine.
inline void write_patient_robot(const std::filesystem::path& robot, const std::filesystem::path& file) {
  write_changed_robot(robot, file,
                      {{"period_s: 0.004", "period_s: 0.01"}, {"rpdo_deadline_s: 0.018", "rpdo_deadline_s: 0.2"}});
}

/// A long, slow move (all joints about 1 rad at 0.6 rad/s) and two seconds of it: the host is in the middle.
/// False: it did not get under way, or was over too soon.
inline bool start_slow_move(RunningArm& arm) {
  if (arm.host({"move", "--joints=0.2,-0.2,-0.2,1.0,0.0"}) != 0) return false;
  arm.conductor().start("host", arm.host_command({"move", "--joints=1.4,0.7,-1.3,2.2,1.2", "--speed", "0.3"}));
  arm.conductor().run_cycles(500);
  return arm.conductor().find("host") != nullptr && !arm.conductor().find("host")->exit_code();
}

/// Largest joint speed between two rows of the truth.
inline double speed_rad_s(const TruthRow& a, const TruthRow& b) {
  return (b.q_true - a.q_true).cwiseAbs().maxCoeff() / (1e-9 * static_cast<double>(b.arm_time_ns - a.arm_time_ns));
}
inline double speed_rad_s(const Truth& truth, std::size_t row) {
  return speed_rad_s(truth.rows.at(row), truth.rows.at(row + 1));
}

/// The frames of the bus so far, as the simulator logged them. What is no frame is left out.
inline std::vector<CandumpLine> read_bus_log(const std::filesystem::path& run_folder) {
  std::vector<CandumpLine> frames;
  std::ifstream log(run_folder / "sim/bus.log");
  for (std::string text; std::getline(log, text);)
    if (const CandumpResult result = parse_candump(text); result.line) frames.push_back(*result.line);
  return frames;
}

/// An EMCY with a code that is not "no error".
inline bool is_emergency(const CanFrame& frame) {
  const std::optional<Emcy> emcy = decode_emcy(frame, static_cast<std::uint8_t>(frame.id & 0x7F));
  return emcy && emcy->code != 0;
}

}  // namespace armsight::demo
