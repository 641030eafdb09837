#include <cmath>

#include "protocol/config.hpp"
#include "protocol/little_endian.hpp"

namespace armsight {

namespace {

/// FNV-1a, 64 bit.
class Hash {
 public:
  void add(std::string_view text) {
    add_bits(text.size());
    for (const char c : text) add_byte(static_cast<std::uint8_t>(c));
  }
  void add(double value) { add_bits(static_cast<std::uint64_t>(std::llround(value * 1e9))); }
  void add(const Pose& T) {
    for (const double v : T.R.reshaped()) add(v);
    for (const double v : T.p) add(v);
  }
  std::uint64_t value() const { return value_; }

 private:
  void add_byte(std::uint8_t byte) { value_ = (value_ ^ byte) * 0x100000001B3; }
  void add_bits(std::uint64_t bits) {
    std::uint8_t raw[8];
    write_le<std::uint64_t>(raw, bits);
    for (const std::uint8_t byte : raw) add_byte(byte);
  }
  std::uint64_t value_ = 0xCBF29CE484222325;
};

}  // namespace

std::uint64_t model_hash(const RobotConfig& robot) {
  Hash hash;
  hash.add("armsight model 1");  // rises when this function's order changes
  hash.add(robot.robot);
  hash.add(robot.arm.joint_count());
  hash.add(robot.arm.chain.T_B_0);
  const JointLimits& limits = robot.arm.limits;
  for (std::size_t i = 0; i < robot.drives.size(); ++i) {
    const auto joint = static_cast<Eigen::Index>(i);
    hash.add(robot.joint_names[i]);
    hash.add(robot.arm.chain.T_after[i]);
    for (const JointVector* v : {&limits.min_rad, &limits.max_rad, &limits.max_speed_rad_s,
                                 &limits.max_acceleration_rad_s2, &limits.max_jerk_rad_s3})
      hash.add((*v)[joint]);
    const DriveConfig& drive = robot.drives[i];
    for (const double v : {double{drive.counts_per_turn}, double(drive.node), double(drive.sign), drive.zero_rad})
      hash.add(v);
  }
  for (const int v : {int{robot.hand.node}, robot.hand.open_counts, robot.hand.closed_counts, robot.hand_marker.id})
    hash.add(v);
  hash.add(robot.hand_marker.dictionary);
  hash.add(robot.hand_marker.side_m);
  hash.add(robot.arm.T_H_M);
  return hash.value();
}

}  // namespace armsight
