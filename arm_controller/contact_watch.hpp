// Has the arm touched something? A joint that stays behind its set-point, or a torque that gravity does not explain,
// beyond its limit for a while. rad, N·m, s; a limit of 0 watches nothing. Pure; no heap.
#pragma once

#include <cmath>
#include <optional>

#include "protocol/config.hpp"
#include "shared/gravity.hpp"

namespace armsight::arm {

struct Contact {
  int joint = 0;
  bool is_torque = false;
  double value = 0.0, limit = 0.0;
};

class ContactWatch {
 public:
  explicit ContactWatch(const RobotConfig& robot) noexcept
      : limits_(robot.contact),
        chain_(robot.arm.chain),
        links_(robot.soft.links),
        gravity_m_s2_(robot.gravity_m_s2),
        period_s_(robot.controller.period_s) {}

  void reset() noexcept {
    for (double& t : beyond_s_) t = 0.0;
  }

  /// One cycle: set-point and reading of the joints, what the drives say they give, the offsets in force.
  std::optional<Contact> step(const JointVector& command_rad, const JointVector& q_reading,
                              const JointVector& torque_Nm, const JointVector& beta) noexcept {
    const bool has_torque = limits_.torque_Nm > 0.0 && torque_Nm.size() == q_reading.size();
    JointVector torque = JointVector::Zero(q_reading.size());
    if (has_torque) torque = torque_Nm - gravity_torque(chain_, links_, gravity_m_s2_, q_reading + beta);
    std::optional<Contact> found;
    for (Eigen::Index i = 0; i < q_reading.size(); ++i) {
      const double error = std::abs(command_rad[i] - q_reading[i]), pressed = std::abs(torque[i]);
      const bool is_behind = limits_.following_error_rad > 0.0 && error > limits_.following_error_rad;
      const bool is_pressed = has_torque && pressed > limits_.torque_Nm;
      double& beyond_s = beyond_s_[static_cast<std::size_t>(i)];
      beyond_s = is_behind || is_pressed ? beyond_s + period_s_ : 0.0;
      if (found || beyond_s < limits_.time_s || !(is_behind || is_pressed)) continue;
      if (is_behind)
        found = Contact{static_cast<int>(i), false, error, limits_.following_error_rad};
      else
        found = Contact{static_cast<int>(i), true, pressed, limits_.torque_Nm};
    }
    return found;
  }

 private:
  ContactLimits limits_;
  SerialChain chain_;
  LinkMasses links_;
  Vector3 gravity_m_s2_;
  double period_s_;
  std::array<double, kMaxJoints> beyond_s_{};
};

}  // namespace armsight::arm
