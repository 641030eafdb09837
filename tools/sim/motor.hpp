// What a drive's power stage moves: a joint of the plant or the fingers. Positions in encoder counts.
#pragma once

#include <cstdint>

#include "shared/time.hpp"

namespace armsight::sim {

/// What a drive asks its motor for where it is an impedance: torque = kp (position - it is) + kd (speed - it has) +
/// torque, at most max_torque_Nm. At the drive's output, before sign and zero.
struct Impedance {
  double position_counts = 0.0, speed_rad_s = 0.0;
  double kp_Nm_rad = 0.0, kd_Nms_rad = 0.0;
  double torque_Nm = 0.0, max_torque_Nm = 0.0;
};

enum class MotorMode : std::uint8_t {
  kOff,     ///< no power, the brake holds
  kFollow,  ///< towards the target
  kImpedance,  ///< a spring and a damper to the target, and a torque
  kStop     ///< brakes on the quick-stop ramp, then holds, powered
};

class Motor {
 public:
  virtual ~Motor() = default;
  /// Samples the encoder; the motor stands at the present time.
  virtual std::int32_t position_counts() = 0;
  virtual std::int16_t torque_permille() const = 0;
  virtual void command(MotorMode mode, std::int32_t target_counts, std::uint16_t torque_limit_permille) = 0;
  /// A motor that is led by position alone goes there.
  virtual void command(const Impedance& wanted) {
    command(MotorMode::kFollow, static_cast<std::int32_t>(wanted.position_counts), 1000);
  }
  /// Spring preset of a variable-stiffness joint, ‰ of its description's.
  virtual void set_stiffness(std::uint16_t) {}
  /// As the drive tells it: a gear behind it may be unknown to it.
  virtual std::uint32_t counts_per_turn() const = 0;
  /// Distance between target and position at which a drive gives up; 0: never.
  virtual std::uint32_t following_window_counts() const = 0;
};

}  // namespace armsight::sim
