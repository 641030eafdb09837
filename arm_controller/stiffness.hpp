// How stiff the joints are and shall be, ‰ of what the robot file gives them. A change takes half a second from end to
// end: a drive that got stiffer in one step would jump to its set-point.
#pragma once

#include <algorithm>

#include "protocol/config.hpp"

namespace armsight::arm {

class Stiffness {
 public:
  static constexpr double kWhole_s = 0.5;

  explicit Stiffness(const RobotConfig& robot) noexcept
      : joint_count_(robot.arm.joint_count()), step_(1000.0 * robot.controller.period_s / kWhole_s) {
    for (std::size_t i = 0; i < robot.drives.size(); ++i)
      now_[i] = goal_[i] = robot.takes_stiffness(i) ? robot.drives[i].stiffness_permille : 1000;
  }

  void order(const std::array<std::uint16_t, kMaxJoints>& permille) noexcept {
    for (std::size_t i = 0; i < static_cast<std::size_t>(joint_count_); ++i) goal_[i] = permille[i];
  }
  void step() noexcept {
    for (std::size_t i = 0; i < static_cast<std::size_t>(joint_count_); ++i)
      now_[i] += std::clamp(goal_[i] - now_[i], -step_, step_);
  }
  std::uint16_t permille(std::size_t joint) const noexcept { return static_cast<std::uint16_t>(now_[joint] + 0.5); }
  std::uint16_t goal_permille(std::size_t joint) const noexcept { return static_cast<std::uint16_t>(goal_[joint]); }
  double share(std::size_t joint) const noexcept { return 1e-3 * now_[joint]; }

 private:
  int joint_count_;
  double step_;
  std::array<double, kMaxJoints> now_{}, goal_{};
};

}  // namespace armsight::arm
