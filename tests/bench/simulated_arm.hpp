// The simulated arm with its real controller, for rows that are measured on whole programs.
#pragma once

#include "tools/report/demo_session.hpp"

namespace armsight::bench {

/// The demo's robot without noise; programs stand beside the benchmark.
inline demo::DemoOptions simulated_arm(const std::string& pace) {
  demo::DemoOptions options;
  options.home = ARMSIGHT_SOURCE_DIR;
  options.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  options.robot_file = options.home / "tools/experiments/demo_robot.yaml";
  options.noise = "clean";
  options.pace = pace;
  return options;
}

}  // namespace armsight::bench
