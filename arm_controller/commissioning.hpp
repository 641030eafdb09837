// Joints whose sign, scale, zero and stop nobody has tried on the arm (host commission does), and what they may do
// until then: one at a time, slowly, within 2° of where power came on, by the drive's own count. What the robot file
// says of such a joint's angle means nothing yet, its limits included.
#pragma once

#include <algorithm>

#include "protocol/config.hpp"

namespace armsight::arm {

class Commissioning {
 public:
  static constexpr double kReach_rad = 2.05 * 3.14159265358979323846 / 180.0;  ///< 2°, and the trim's share
  static constexpr double kSpeed_rad_s = 0.035;                                ///< 2°/s

  explicit Commissioning(const RobotConfig& robot) noexcept : joint_count_(robot.arm.joint_count()) {
    for (std::size_t i = 0; i < robot.drives.size(); ++i) is_open_[i] = !robot.drives[i].is_commissioned;
  }

  bool is_done() const noexcept {
    return std::none_of(is_open_.begin(), is_open_.end(), [](bool open) { return open; });
  }
  bool is_open(int joint) const noexcept { return is_open_[static_cast<std::size_t>(joint)]; }

  /// Those of the file; around the reading at which power came on where a joint is open.
  JointLimits limits_at(const JointLimits& file, const JointVector& q_reading) const noexcept {
    JointLimits out = file;
    for (int i = 0; i < joint_count_; ++i) {
      if (!is_open(i)) continue;
      out.min_rad[i] = q_reading[i] - kReach_rad;
      out.max_rad[i] = q_reading[i] + kReach_rad;
    }
    return out;
  }
  /// Of a joint's working speed.
  double speed_scale(const JointLimits& file, int joint) const noexcept {
    return std::min(1.0, kSpeed_rad_s / file.max_speed_rad_s[joint]);
  }

 private:
  int joint_count_;
  std::array<bool, kMaxJoints> is_open_{};
};

}  // namespace armsight::arm
