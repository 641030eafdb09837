// One run of the whole job: starts the programs a user would deploy, calls the host's verbs in the order of chapter 8,
// and gathers what they left for the report.
#pragma once

#include "protocol/descriptor.hpp"
#include "tools/report/conductor.hpp"
#include "tools/report/report.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight::demo {

struct DemoOptions {
  std::filesystem::path home;        ///< the repository: configuration files
  std::filesystem::path programs;    ///< folder of arm_sim, arm_controller, host
  std::filesystem::path report_dir, robot_file;
  std::uint64_t seed = 1;
  std::string noise = "nominal", pace = "lockstep";
  std::vector<std::string> can_interfaces;   ///< one for each bus of the robot; none: emulated
  std::filesystem::path true_robot_file;  ///< what arm_sim simulates where it is not robot_file: for tests
  std::map<std::string, std::vector<std::string>> tracers;  ///< for tests: what a program is started through
  std::vector<std::string> controller_flags;                ///< for tests: what the controller is told besides
};

/// A verb failed: exit code 1, or the verb's own.
class RunFailed : public std::runtime_error {
 public:
  RunFailed(const std::string& what, int code) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// The simulated robot and its controller, running.
class RunningArm {
 public:
  /// `run_dir` keeps states, recordings and logs; ConfigError where another run works in it.
  RunningArm(const DemoOptions& options, const std::filesystem::path& run_dir, bool is_verbose);

  /// host VERB …; its exit code.
  int host(const std::vector<std::string>& verb);
  /// Started by the constructor; again, where it was, by tests that killed it.
  void start_controller();
  std::vector<std::string> host_command(const std::vector<std::string>& verb) const;
  Conductor& conductor() { return conductor_; }
  /// Ends the controller, asks for the truth.
  Truth finish();
  /// Names of the files that faults left in the controller's state folder.
  std::vector<std::string> black_boxes() const;
  const std::filesystem::path& run_dir() const { return run_dir_; }
  /// ADDR:PORT where the controller listens.
  const std::string& link() const { return link_; }
  const std::string& bus_line() const { return bus_line_; }
  const std::vector<std::string>& commands() const { return commands_; }
  /// Every line the host printed in its last verb.
  const std::vector<std::string>& host_lines() const { return host_lines_; }

 private:
  std::string server(const std::string& name, const std::vector<std::string>& arguments,
                     const std::string& ready_prefix);
  std::vector<std::string> program(const std::string& name, const std::vector<std::string>& arguments) const;
  std::vector<std::string> bus_arguments() const;

  DemoOptions options_;
  std::filesystem::path run_dir_;
  Descriptor run_lock_;
  TemporaryFolder sockets_;
  Conductor conductor_;
  std::string camera_, link_, bus_line_;
  std::vector<std::string> commands_, host_lines_;
};

/// The whole job; fills everything but files to write. Throws RunFailed, ProgramLost, Interrupted, ConfigError.
Report run_demo(const DemoOptions& options);

}  // namespace armsight::demo
