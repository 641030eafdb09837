// The command line of arm_sim → plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/sim/noise.hpp"
#include "tools/sim/truth.hpp"

namespace armsight::sim {

struct ArmSimFlags {
  std::string robot_file, scene_file, clock_path, camera_address, log_file;
  std::vector<std::string> emulated_bus_paths, can_interfaces;  ///< one of the two, one entry a bus
  std::uint64_t seed = 1;
  NoiseSet noise = NoiseSet::kNominal;
  CameraMount mount = CameraMount::kNear;
  bool is_lockstep = true;
  std::optional<double> rate_hz;  ///< instead of the robot file's
};

/// The exit code when there is nothing to run: 0 after --help, 2 after a bad flag (said on stderr).
std::optional<int> parse_flags(int argc, char** argv, ArmSimFlags& flags);

}  // namespace armsight::sim
