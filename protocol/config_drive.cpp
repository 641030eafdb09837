#include "protocol/config_drive.hpp"

#include <cmath>
#include <numbers>

namespace armsight {

namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

/// Node ids of joints and hand must differ; 127 is the controller's own.
std::uint8_t read_node(const YamlValue& node, std::set<std::int64_t>& taken) {
  const auto id = node.valid_integer(1, 126);
  if (id && !taken.insert(*id).second) node.refuse("node id is already taken");
  return static_cast<std::uint8_t>(id.value_or(0));
}

std::uint8_t read_bus(const YamlValue& drive) {
  const YamlValue bus = drive.optional_key("bus");
  return bus.exists() ? static_cast<std::uint8_t>(bus.integer(0, kMaxBuses - 1)) : std::uint8_t{0};
}

DriveFamily read_family(const YamlValue& family) {
  if (!family.exists()) return DriveFamily::kCanopen;
  const std::string name = family.text();
  if (name != "canopen" && name != "damiao") family.refuse("must be canopen or damiao");
  return name == "damiao" ? DriveFamily::kDamiao : DriveFamily::kCanopen;
}

/// `second` beside cyclic position; csp is the default.
DriveMode read_mode(const YamlValue& mode, const char* name, DriveMode second) {
  if (!mode.exists()) return DriveMode::kCyclicPosition;
  const std::string text = mode.text();
  if (text == name) return second;
  if (text != "csp") mode.refuse(std::string("must be csp or ") + name);
  return DriveMode::kCyclicPosition;
}

constexpr double kSoftestShare = 0.1;  // of kp_Nm_rad, where the file names no softest

ObjectAddress read_object(const YamlValue& object) {
  const YamlValue index = object.key("index");
  const std::uint64_t address = index.hexadecimal();
  if (address > 0xFFFF) index.refuse("must be at most 0xFFFF");
  return {static_cast<std::uint16_t>(address), static_cast<std::uint8_t>(object.key("sub").integer(0, 255))};
}

/// A preset that nothing takes would look like one that is in force.
void read_stiffness(const YamlValue& drive, DriveConfig& out) {
  const YamlValue preset = drive.optional_key("stiffness_permille");
  if (!preset.exists()) return;
  out.stiffness_permille = static_cast<std::uint16_t>(preset.integer(0, 1000));
  if (out.family == DriveFamily::kCanopen && !out.stiffness_object)
    preset.refuse("needs a drive that takes it: family damiao, or stiffness_object");
}

/// Set-points and samples travel as 32-bit counts.
void read_canopen(const YamlValue& drive, double farthest_rad, DriveConfig& out) {
  const YamlValue counts = drive.key("counts_per_turn");
  out.counts_per_turn = counts.positive(2147483647);
  out.mode = read_mode(drive.optional_key("mode"), "csv", DriveMode::kCyclicVelocity);
  if (const YamlValue gear = drive.optional_key("gear"); gear.exists()) out.gear = gear.positive(100000);
  if (const YamlValue object = drive.optional_key("stiffness_object"); object.exists())
    out.stiffness_object = read_object(object);
  const YamlValue homing = drive.optional_key("homing_method");
  if (homing.exists()) out.homing_method = static_cast<std::uint8_t>(homing.integer(35, 37));
  if (out.homing_method == 36) homing.refuse("must be 35 or 37");
  const double most_counts = (farthest_rad + std::abs(out.zero_rad)) * out.counts_per_turn / kTurn_rad;
  if (most_counts >= 2147483648.0) counts.refuse("limits and zero_rad are beyond 32-bit counts");
}

/// A code beyond ±position_range_rad is silently held there, and at power-on the drive may count from a turn beside.
void read_damiao(const YamlValue& drive, std::set<std::int64_t>& taken, double farthest_rad, DriveConfig& out) {
  MitConfig& mit = out.mit;
  mit.reply_id = read_node(drive.key("reply_id"), taken);
  const YamlValue range = drive.key("position_range_rad"), kd = drive.key("kd_Nms_rad");
  mit.ranges.position_rad = range.positive(1000);
  mit.ranges.speed_rad_s = drive.key("speed_range_rad_s").positive(1000);
  mit.ranges.torque_Nm = drive.key("torque_range_Nm").positive(1000);
  mit.kp_Nm_rad = drive.key("kp_Nm_rad").number(0.1, kMitMaxKp_Nm_rad);
  mit.kd_Nms_rad = kd.number(0, kMitMaxKd_Nms_rad);
  if (kd.exists() && mit.kd_Nms_rad == 0.0) kd.refuse("must be > 0: stiffness without damping swings");
  const YamlValue softest = drive.optional_key("softest_kp_Nm_rad");
  mit.softest_kp_Nm_rad = softest.exists() ? softest.number(0.1, kMitMaxKp_Nm_rad) : kSoftestShare * mit.kp_Nm_rad;
  if (softest.exists() && mit.softest_kp_Nm_rad > mit.kp_Nm_rad) softest.refuse("must be at most kp_Nm_rad");
  if (const YamlValue fd = drive.optional_key("fd"); fd.exists()) mit.is_fd = fd.boolean();
  if (range.exists() && farthest_rad + std::abs(out.zero_rad) + kTurn_rad > mit.ranges.position_rad)
    range.refuse("must reach a turn beyond the limits and zero_rad: the drive wakes up within one turn");
  constexpr double kCodes = 65535.0;
  out.counts_per_turn = kCodes / (2.0 * mit.ranges.position_rad) * kTurn_rad;
}

}  // namespace

DriveConfig read_drive(const YamlValue& drive, std::set<std::int64_t>& taken, double farthest_rad) {
  DriveConfig out;
  out.node = read_node(drive.key("node"), taken);
  out.bus = read_bus(drive);
  const YamlValue sign = drive.key("sign");
  out.sign = static_cast<int>(sign.integer(-1, 1));
  if (out.sign == 0) sign.refuse("must be 1 or -1");
  out.zero_rad = drive.key("zero_rad").number(-kTurn_rad, kTurn_rad);
  out.family = read_family(drive.optional_key("family"));
  if (out.family == DriveFamily::kDamiao) read_damiao(drive, taken, farthest_rad, out);
  else read_canopen(drive, farthest_rad, out);
  read_stiffness(drive, out);
  if (const YamlValue done = drive.optional_key("commissioned"); done.exists()) out.is_commissioned = done.boolean();
  return out;
}

HandConfig read_hand(const YamlValue& hand, std::set<std::int64_t>& taken) {
  HandConfig out;
  out.node = read_node(hand.key("node"), taken);
  out.bus = read_bus(hand);
  out.open_counts = static_cast<int>(hand.key("open_counts").integer(-2147483647, 2147483647));
  const YamlValue closed = hand.key("closed_counts");
  out.closed_counts = static_cast<int>(closed.integer(-2147483647, 2147483647));
  if (closed.exists() && out.closed_counts == out.open_counts) closed.refuse("must differ from open_counts");
  out.mode = read_mode(hand.optional_key("mode"), "profile_position", DriveMode::kProfilePosition);
  return out;
}

}  // namespace armsight
