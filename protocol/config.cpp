#include "protocol/config.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "protocol/config_drive.hpp"
#include "protocol/config_soft.hpp"
#include "protocol/config_values.hpp"

namespace armsight {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDataBitrate_bit_s = 5e6;
constexpr double kBusLoadLimit = 0.9;  // the rest is for frames sent again (controller.md §3.2)

DhRow read_dh(const YamlValue& dh) {
  const YamlValue a_m = dh.key("a_m"), alpha_rad = dh.key("alpha_rad");
  DhRow row;
  row.a_m = a_m.number(-1e6, 1e6);
  row.alpha_rad = alpha_rad.number(-kPi - 1e-9, kPi + 1e-9);
  row.d_m = dh.key("d_m").number(-2, 2);
  row.theta_rad = dh.key("theta_rad").number(-2 * kPi, 2 * kPi);
  // The thesis' table 7.1 prints alpha under the head a, and a under alpha.
  const bool is_right_angle = std::abs(std::abs(row.a_m) - kPi / 2) < 1e-3;
  if (is_right_angle) a_m.refuse("is a right angle, not a length: were a_m and alpha_rad swapped?");
  else if (std::abs(row.a_m) > 1) a_m.refuse("must be between -1 and 1");
  return row;
}

Pose read_link(const YamlValue& joint) {
  const YamlValue dh = joint.optional_key("dh"), frame = joint.optional_key("frame");
  if (dh.exists() == frame.exists()) {
    joint.refuse("needs exactly one of dh and frame");
    return {};
  }
  return dh.exists() ? dh_transform(read_dh(dh)) : read_frame(frame);
}

/// Bus 1 alone would be bus 0.
void check_buses(const YamlValue& root, const RobotConfig& robot) {
  for (int bus = 0; bus < robot.bus_count(); ++bus) {
    const auto is_here = [bus](const DriveConfig& drive) { return drive.bus == bus; };
    if (robot.hand.bus == bus || std::ranges::any_of(robot.drives, is_here)) continue;
    root.key("joints").refuse("no drive is on bus " + std::to_string(bus) + ", though one is on a higher one");
  }
}

void read_limits(const YamlValue& joint, Eigen::Index i, JointLimits& limits) {
  const YamlValue min_rad = joint.key("min_rad");
  limits.min_rad[i] = min_rad.number(-7, 7);
  limits.max_rad[i] = joint.key("max_rad").number(-7, 7);
  if (limits.min_rad[i] >= limits.max_rad[i]) min_rad.refuse("must be below max_rad");
  limits.max_speed_rad_s[i] = joint.key("max_speed_rad_s").positive(20);
  limits.max_acceleration_rad_s2[i] = joint.key("max_acceleration_rad_s2").positive(1000);
  limits.max_jerk_rad_s3[i] = joint.key("max_jerk_rad_s3").positive(100000);
}

void read_joints(const YamlValue& root, std::set<std::int64_t>& nodes, RobotConfig& out) {
  const std::vector<YamlValue> joints = root.key("joints").list(1, kMaxJoints);
  const auto count = static_cast<Eigen::Index>(joints.size());
  JointLimits& limits = out.arm.limits;
  for (JointVector* v : {&limits.min_rad, &limits.max_rad, &limits.max_speed_rad_s, &limits.max_acceleration_rad_s2,
                         &limits.max_jerk_rad_s3})
    v->setZero(count);
  out.arm.chain.joint_count = static_cast<int>(count);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const YamlValue name = joints[i].key("name");
    out.joint_names.push_back(name.text());
    const auto last = out.joint_names.end() - 1;
    if (std::find(out.joint_names.begin(), last, *last) != last) name.refuse("name is already taken");
    out.arm.chain.T_after[i] = read_link(joints[i]);
    const auto joint = static_cast<Eigen::Index>(i);
    read_limits(joints[i], joint, limits);
    const double farthest_rad = std::max(std::abs(limits.min_rad[joint]), std::abs(limits.max_rad[joint]));
    out.drives.push_back(read_drive(joints[i].key("drive"), nodes, farthest_rad));
    out.soft.links[i] = read_link_mass(joints[i]);
    out.soft.springs[i] = read_spring(joints[i]);
    const bool is_led_by_position = out.drives.back().mode == DriveMode::kCyclicPosition;
    if (out.soft.is_soft(static_cast<int>(i)) && !is_led_by_position)
      joints[i].refuse("a joint with a spring needs drive mode csp: its target is moved by the spring's bend");
  }
}

MarkerConfig read_marker(const YamlValue& marker) {
  MarkerConfig out;
  const YamlValue dictionary = marker.key("dictionary"), id = marker.key("id");
  out.dictionary = dictionary.text();
  const int size = marker_dictionary_size(out.dictionary);
  if (size == 0) dictionary.refuse("is no ArUco dictionary such as DICT_4X4_50");
  out.id = static_cast<int>(id.integer(0, 1023));
  if (size != 0 && out.id >= size) id.refuse("the dictionary has " + std::to_string(size) + " markers, from 0");
  out.side_m = marker.key("side_m").positive(1);
  return out;
}

ControllerConfig read_controller(const YamlValue& c) {
  ControllerConfig out{};
  const YamlValue period = c.key("period_s");
  out.period_s = period.number(0.001, 0.1);
  if (const char* rule = broken_period_rule(out.period_s); rule && std::isfinite(out.period_s)) period.refuse(rule);
  out.bus_bitrate_bit_s = c.key("bus_bitrate_bit_s").number(10000, 1000000);
  out.still_speed_rad_s = c.key("still_speed_rad_s").positive(1);
  out.still_time_s = c.key("still_time_s").positive(10);
  out.goal_tolerance_rad = c.key("goal_tolerance_rad").positive(0.1);
  out.lease_s = c.key("lease_s").number(0.02, 1);  // controller.md §11.1
  const YamlValue deadline = c.key("rpdo_deadline_s");
  out.rpdo_deadline_s = deadline.positive(1);
  if (const char* rule = broken_deadline_rule(out.rpdo_deadline_s, out.period_s)) deadline.refuse(rule);
  out.heartbeat_s = c.key("heartbeat_s").number(0.02, 5);
  out.look_time_bound_s = c.key("look_time_bound_s").positive(1);
  out.look_max_speed_rad_s = c.key("look_max_speed_rad_s").positive(20);
  const YamlValue data_rate = c.optional_key("bus_data_bitrate_bit_s"), load = c.optional_key("bus_load_limit");
  out.bus_data_bitrate_bit_s = data_rate.exists() ? data_rate.number(100000, 8000000) : kDataBitrate_bit_s;
  out.bus_load_limit = load.exists() ? load.positive(1) : kBusLoadLimit;
  return out;
}

EkfOptions read_filter(const YamlValue& f) {
  EkfOptions out;
  out.prior_position_sigma_m = f.key("prior_position_sigma_m").positive(10);
  out.prior_rotation_sigma_rad = f.key("prior_rotation_sigma_rad").positive(kPi);
  out.prior_beta_sigma_rad = f.key("prior_beta_sigma_rad").positive(kPi);
  out.prior_beta1_sigma_rad = f.key("prior_beta1_sigma_rad").positive(kPi);
  out.encoder_sigma_rad = f.key("encoder_sigma_rad").positive(1);
  out.floor_position_sigma_m = f.key("floor_position_sigma_m").positive(1);
  out.floor_rotation_sigma_rad = f.key("floor_rotation_sigma_rad").positive(kPi);
  out.cost_gate = f.key("cost_gate").positive(1000);
  if (const YamlValue v = f.optional_key("max_iterations"); v.exists())
    out.max_iterations = static_cast<int>(v.integer(1, 50));
  const auto optional = [&](const char* key, double& value, double max) {
    if (const YamlValue v = f.optional_key(key); v.exists()) value = v.number(0, max);
  };
  optional("walk_position_m_per_sqrt_min", out.walk_position_m_per_sqrt_min, 1);
  optional("walk_rotation_rad_per_sqrt_min", out.walk_rotation_rad_per_sqrt_min, 1);
  optional("walk_beta_rad_per_sqrt_min", out.walk_beta_rad_per_sqrt_min, 1);
  return out;
}

ContactLimits read_contact(const YamlValue& contact) {
  ContactLimits out;
  if (!contact.exists()) return out;
  out.following_error_rad = contact.key("following_error_rad").positive(1);
  if (const YamlValue torque = contact.optional_key("torque_Nm"); torque.exists())
    out.torque_Nm = torque.positive(1000);
  out.time_s = contact.key("time_s").number(0, 1);
  return out;
}

void read_postures(const YamlValue& postures, RobotConfig& out) {
  const auto count = static_cast<std::size_t>(out.arm.joint_count());
  const JointLimits& limits = out.arm.limits;
  for (const auto& [name, value] : postures.entries()) {
    const std::vector<YamlValue> angles = value.list(count > 0 ? count : 1, count > 0 ? count : kMaxJoints);
    JointVector q = JointVector::Zero(static_cast<Eigen::Index>(angles.size()));
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const auto joint = static_cast<Eigen::Index>(i);
      const bool has_limits = count > 0 && limits.min_rad[joint] < limits.max_rad[joint];  // else that was refused
      q[joint] = has_limits ? angles[i].number(limits.min_rad[joint], limits.max_rad[joint]) : angles[i].number(-7, 7);
    }
    out.postures.emplace(name, q);
  }
}

}  // namespace

std::optional<InterpolationPeriod> interpolation_period(double period_s) {
  constexpr double kRounding = 1e-6;
  for (const int exponent : {-3, -4}) {
    const double units = period_s * std::pow(10.0, -exponent);
    const double whole = std::round(units);
    if (whole >= 1 && whole <= 255 && std::abs(units - whole) < kRounding)
      return InterpolationPeriod{static_cast<std::uint8_t>(whole), static_cast<std::int8_t>(exponent)};
  }
  return std::nullopt;
}

const char* broken_period_rule(double period_s) {
  return interpolation_period(period_s)
             ? nullptr
             : "must be a whole number, 1 to 255, of 1 ms or of 0.1 ms (CANopen 0x60C2)";
}

const char* broken_deadline_rule(double rpdo_deadline_s, double period_s) {
  return rpdo_deadline_s < 2 * period_s ? "must be at least two periods: one lost frame is no fault" : nullptr;
}

int RobotConfig::bus_count() const {
  int highest = hand.bus;
  for (const DriveConfig& drive : drives) highest = std::max<int>(highest, drive.bus);
  return highest + 1;
}

std::optional<std::size_t> RobotConfig::first_uncommissioned() const {
  const auto found = std::ranges::find(drives, false, &DriveConfig::is_commissioned);
  return found == drives.end() ? std::nullopt : std::optional<std::size_t>(found - drives.begin());
}

bool RobotConfig::takes_stiffness(std::size_t joint) const {
  return drives[joint].family == DriveFamily::kDamiao || drives[joint].stiffness_object.has_value();
}

bool RobotConfig::has_fd_drive(int bus) const {
  return std::ranges::any_of(drives, [bus](const DriveConfig& drive) { return drive.bus == bus && drive.mit.is_fd; });
}

RobotConfig parse_robot(std::string_view text, const std::string& file_name) {
  const StrictYaml yaml = StrictYaml::parse(text, file_name);
  const YamlValue root = yaml.root();
  RobotConfig out;
  std::set<std::int64_t> nodes;
  out.robot = root.key("robot").text();
  out.gravity_m_s2 = read_vector(root.key("gravity_m_s2"), 20);
  if (const YamlValue base = root.optional_key("base_to_joint1"); base.exists())
    out.arm.chain.T_B_0 = read_frame(base);
  read_joints(root, nodes, out);
  out.soft.chain = out.arm.chain;
  out.soft.gravity_m_s2 = out.gravity_m_s2;
  out.hand = read_hand(root.key("hand"), nodes);
  check_buses(root, out);
  const YamlValue marker = root.key("hand_marker");
  out.hand_marker = read_marker(marker);
  out.arm.T_H_M = read_pose(marker);
  out.camera_hint_T_C_B = read_pose(root.key("camera_hint"));
  out.controller = read_controller(root.key("controller"));
  out.filter = read_filter(root.key("filter"));
  out.contact = read_contact(root.optional_key("contact"));
  out.collision = read_collision(root.optional_key("collision"), out.arm.joint_count());
  if (const YamlValue postures = root.optional_key("postures"); postures.exists()) read_postures(postures, out);
  yaml.finish();
  return out;
}

BusRates bus_rates(const RobotConfig& robot) {
  return {robot.controller.bus_bitrate_bit_s, robot.controller.bus_data_bitrate_bit_s};
}

RobotConfig load_robot(const std::filesystem::path& file) { return parse_robot(read_text_file(file), file.string()); }

}  // namespace armsight
