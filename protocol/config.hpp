// The robot file: strict YAML → plain structs. load() lists every violation at once as "file:line:column: key = value:
// rule"; unknown and repeated keys are violations. YAML goes no further than strict_yaml.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/config_collision.hpp"
#include "protocol/config_error.hpp"
#include "protocol/drive_family.hpp"
#include "protocol/mit_frames.hpp"
#include "shared/arm_model.hpp"
#include "shared/joint_offset_ekf.hpp"
#include "shared/soft_joints.hpp"

namespace armsight {

/// Mode of operation of a drive: the numbers of CiA 402's 0x6060.
enum class DriveMode : std::uint8_t { kProfilePosition = 1, kHoming = 6, kCyclicPosition = 8, kCyclicVelocity = 9 };

inline constexpr int kMaxBuses = 4;

/// Of a DAMIAO drive alone.
struct MitConfig {
  std::uint8_t reply_id = 0;  ///< its master id: the identifier of its samples
  MitRanges ranges;
  double kp_Nm_rad = 0.0, kd_Nms_rad = 0.0;  ///< at full stiffness
  double softest_kp_Nm_rad = 0.0;            ///< at stiffness 0
  bool is_fd = false;
};

/// q = sign · 2π · counts / counts_per_turn + zero_rad.
struct DriveConfig {
  std::uint8_t node = 0;
  std::uint8_t bus = 0;                         ///< which of the arm's CAN buses
  DriveFamily family = DriveFamily::kCanopen;
  MitConfig mit;
  double counts_per_turn = 0;                   ///< of the joint; DAMIAO: of the position's 16-bit code
  double gear = 1.0;                            ///< counts_per_turn over what the drive itself tells: a gear it leaves out
  bool is_commissioned = false;                 ///< sign, scale, zero and stop were tried on the arm (host commission)
  std::uint16_t stiffness_permille = 1000;      ///< preset at start
  std::optional<ObjectAddress> stiffness_object;///< CANopen: where the drive takes it, u16 in ‰
  int sign = 1;
  double zero_rad = 0.0;
  DriveMode mode = DriveMode::kCyclicPosition;  ///< or kCyclicVelocity: 0x60FF, counts/s
  std::uint8_t homing_method = 0;               ///< 35 or 37: "here is zero", before each first enabling; 0: absolute encoder
};

struct HandConfig {
  std::uint8_t node = 0;
  std::uint8_t bus = 0;
  int open_counts = 0;
  int closed_counts = 0;
  DriveMode mode = DriveMode::kCyclicPosition;  ///< or kProfilePosition: the drive leads the fingers by itself
};

struct MarkerConfig {
  std::string dictionary;
  int id = 0;
  double side_m = 0.0;
};

struct ControllerConfig {
  double period_s, bus_bitrate_bit_s;
  double bus_data_bitrate_bit_s;  ///< of CAN FD frames
  double still_speed_rad_s, still_time_s;
  double goal_tolerance_rad;
  double lease_s, rpdo_deadline_s, heartbeat_s;
  double look_time_bound_s, look_max_speed_rad_s;
  double bus_load_limit;   ///< share of a bus' time that the worst case may take (bus_budget)
};

/// What counts as having touched something; 0: not watched.
struct ContactLimits {
  double following_error_rad = 0.0, torque_Nm = 0.0, time_s = 0.0;
};

/// 0x60C2 (CiA 402) tells a drive the period as value · 10^exponent s.
struct InterpolationPeriod {
  std::uint8_t value = 0;
  std::int8_t exponent = 0;
};
/// nullopt: the period is no whole number, 1 … 255, of 1 ms or of 0.1 ms.
std::optional<InterpolationPeriod> interpolation_period(double period_s);

/// Rules that a changed period may break although the file kept them: the text of the one broken, or nullptr.
const char* broken_period_rule(double period_s);
const char* broken_deadline_rule(double rpdo_deadline_s, double period_s);

struct RobotConfig {
  std::string robot;
  Vector3 gravity_m_s2;
  ArmModel arm;                          ///< T_H_M from hand_marker
  std::vector<std::string> joint_names;
  std::vector<DriveConfig> drives;       ///< one a joint
  ContactLimits contact;
  CollisionConfig collision;             ///< not in the hash: the controller's file alone decides
  SoftArm soft;                          ///< masses and springs
  HandConfig hand;
  MarkerConfig hand_marker;
  Pose camera_hint_T_C_B;
  ControllerConfig controller;
  EkfOptions filter;
  /// Buses that drives and hand are on: 0 … bus_count() - 1, none left out.
  int bus_count() const;
  /// nullopt: every joint is commissioned.
  std::optional<std::size_t> first_uncommissioned() const;
  /// Its drive can be told how stiff to be.
  bool takes_stiffness(std::size_t joint) const;
  /// Some drive on that bus speaks CAN FD.
  bool has_fd_drive(int bus) const;

  std::map<std::string, JointVector> postures;  ///< named, real angles, inside the limits
};

BusRates bus_rates(const RobotConfig& robot);

/// Throws ConfigError.
RobotConfig load_robot(const std::filesystem::path& file);
/// The same from text; `file_name` stands in the messages.
RobotConfig parse_robot(std::string_view text, const std::string& file_name);

/// What host and controller must agree on: geometry, limits, signs, zeros, marker mount. Not rates, not the hint.
/// FNV-1a, 64 bit, over names and numbers in a fixed order, the numbers rounded to 1e-9 so that no machine's last bit
/// of a sine counts.
std::uint64_t model_hash(const RobotConfig& robot);

}  // namespace armsight
