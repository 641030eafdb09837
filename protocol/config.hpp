// The robot file: strict YAML → plain structs. load() lists every violation at once as "file:line:column: key = value:
// rule"; unknown and repeated keys are violations. YAML goes no further than config.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "shared/arm_model.hpp"
#include "shared/joint_offset_ekf.hpp"

namespace armsight {

/// Bad input from people; what() holds one violation a line. Caught once in main: exit code 2.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct DriveConfig {
  std::uint8_t node = 0;
  double counts_per_turn = 0;
  int sign = 1;
  double zero_rad = 0.0;
};

struct HandConfig {
  std::uint8_t node = 0;
  int open_counts = 0;
  int closed_counts = 0;
};

struct MarkerConfig {
  std::string dictionary;
  int id = 0;
  double side_m = 0.0;
};

struct ControllerConfig {
  double period_s, bus_bitrate_bit_s;
  double still_speed_rad_s, still_time_s;
  double goal_tolerance_rad;
  double lease_s, rpdo_deadline_s, heartbeat_s;
  double look_time_bound_s, look_max_speed_rad_s;
};

struct RobotConfig {
  std::string robot;
  Vector3 gravity_m_s2;
  ArmModel arm;                          ///< T_H_M from hand_marker
  std::vector<std::string> joint_names;
  std::vector<DriveConfig> drives;       ///< one a joint
  HandConfig hand;
  MarkerConfig hand_marker;
  Pose camera_hint_T_C_B;
  ControllerConfig controller;
  EkfOptions filter;
};

/// Throws ConfigError.
RobotConfig load_robot(const std::filesystem::path& file);

/// What host and controller must agree on: geometry, limits, signs, zeros, marker mount. Not rates, not the hint.
std::uint64_t model_hash(const RobotConfig& robot);

}  // namespace armsight
