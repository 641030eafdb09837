#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "tools/report/demo_session.hpp"

namespace armsight::demo {

namespace {

namespace fs = std::filesystem;

/// Only a folder that an earlier run made is emptied, and none that a run works in: the mark is its lock.
Descriptor prepare_run_folder(const fs::path& run_dir) {
  const fs::path mark = run_dir / "made-by-armsight-demo";
  if (fs::exists(run_dir) && !fs::exists(mark)) {
    throw ConfigError(run_dir.string() + ": exists and was not made by an earlier demo: choose another --report");
  }
  fs::create_directories(run_dir);
  Descriptor lock(::open(mark.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (lock.get() < 0) throw ConfigError(mark.string() + ": cannot be written: " + std::strerror(errno));
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw ConfigError(run_dir.string() + ": another run works there: choose another --report");
  for (const fs::directory_entry& entry : fs::directory_iterator(run_dir))
    if (entry.path() != mark) fs::remove_all(entry.path());
  for (const char* folder : {"sim", "controller", "host", "results"}) fs::create_directories(run_dir / folder);
  std::ofstream(mark) << "tools/demo empties this folder when it runs again.\n";
  return lock;
}

Descriptor prepared(const fs::path& run_dir) {
  try {
    return prepare_run_folder(run_dir);
  } catch (const fs::filesystem_error& e) {
    throw ConfigError(run_dir.string() + ": cannot be made: " + e.code().message());
  }
}

}  // namespace

RunningArm::RunningArm(const DemoOptions& options, const fs::path& run_dir, bool is_verbose)
    : options_(options),
      run_dir_(fs::absolute(run_dir)),
      run_lock_(prepared(run_dir_)),
      conductor_(run_dir_ / "programs.log", is_verbose) {
  const fs::path& true_robot = options_.true_robot_file.empty() ? options_.robot_file : options_.true_robot_file;
  std::vector<std::string> arguments{"--robot",  true_robot.string(),
                                     "--scene",  (options_.home / "tools/sim/scene.yaml").string(),
                                     "--seed",   std::to_string(options_.seed),
                                     "--noise",  options_.noise,
                                     "--pace",   options_.pace,
                                     "--clock",  (sockets_.path() / "clock").string(),
                                     "--camera", "127.0.0.1:0",
                                     "--log",    (run_dir_ / "sim/bus.log").string()};
  for (const std::string& word : bus_arguments()) arguments.push_back(word);
  server("arm_sim", arguments, "arm_sim: ready");
  camera_ = conductor_.find("arm_sim")->line_after("arm_sim: camera ").value_or("");
  conductor_.join_clock(sockets_.path() / "clock");
  start_controller();
}

void RunningArm::start_controller() {
  const std::string listen = link_.empty() ? "127.0.0.1:0" : link_;
  std::vector<std::string> arguments{"--config", options_.robot_file.string(), "--listen", listen,
                                     "--state", (run_dir_ / "controller").string()};
  if (options_.can_interfaces.empty())
    arguments.insert(arguments.end(), {"--clock", "sim:" + (sockets_.path() / "clock").string()});
  for (const std::string& word : bus_arguments()) arguments.push_back(word);
  for (const std::string& word : options_.controller_flags) arguments.push_back(word);
  link_ = server("arm_controller", arguments, "arm_controller: listening on ");
  bus_line_ = conductor_.find("arm_controller")->line_after("arm_controller: bus ").value_or("");
}

std::vector<std::string> RunningArm::bus_arguments() const {
  std::vector<std::string> words;
  for (const std::string& interface : options_.can_interfaces) words.insert(words.end(), {"--can", interface});
  if (!words.empty()) return words;
  const int count = load_robot(options_.robot_file).bus_count();
  for (int bus = 0; bus < count; ++bus)
    words.insert(words.end(), {"--bus", "emulated:" + (sockets_.path() / ("bus" + std::to_string(bus))).string()});
  return words;
}

std::vector<std::string> RunningArm::program(const std::string& name, const std::vector<std::string>& arguments) const {
  std::vector<std::string> command;
  if (const auto tracer = options_.tracers.find(name); tracer != options_.tracers.end()) command = tracer->second;
  command.push_back((options_.programs / name).string());
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

std::string RunningArm::server(const std::string& name, const std::vector<std::string>& arguments,
                               const std::string& ready_prefix) {
  const std::string rest = conductor_.start_server(name, program(name, arguments), ready_prefix);
  commands_.push_back(conductor_.find(name)->command_line());
  return rest;
}

std::vector<std::string> RunningArm::host_command(const std::vector<std::string>& verb) const {
  std::vector<std::string> arguments{"--arm",    link_,
                                     "--state",  (run_dir_ / "host").string(),
                                     "--robot",  options_.robot_file.string(),
                                     "--camera", "sim:" + camera_,
                                     "--clock",  "sim:" + (sockets_.path() / "clock").string()};
  arguments.insert(arguments.end(), verb.begin(), verb.end());
  return program("host", arguments);
}

int RunningArm::host(const std::vector<std::string>& verb) {
  const std::vector<std::string> command = host_command(verb);
  std::string line;
  for (const std::string& word : command) line += (line.empty() ? "" : " ") + word;
  commands_.push_back(line);
  return conductor_.run("host", command, &host_lines_);
}

Truth RunningArm::finish() {
  conductor_.end("arm_controller");  // in order, so that its recordings are whole
  const fs::path file = run_dir_ / "sim/truth.json";
  conductor_.finish(file);
  return load_truth(file);
}

std::vector<std::string> RunningArm::black_boxes() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(run_dir_ / "controller")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("blackbox-")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace armsight::demo
