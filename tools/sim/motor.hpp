// What a drive's power stage moves: a joint of the plant or the fingers. Positions in encoder counts.
#pragma once

#include <cstdint>

#include "shared/time.hpp"

namespace armsight::sim {

enum class MotorMode : std::uint8_t {
  kOff,     ///< no power, the brake holds
  kFollow,  ///< towards the target
  kStop     ///< brakes on the quick-stop ramp, then holds, powered
};

class Motor {
 public:
  virtual ~Motor() = default;
  /// Samples the encoder; the motor stands at the present time.
  virtual std::int32_t position_counts() = 0;
  virtual std::int16_t torque_permille() const = 0;
  virtual void command(MotorMode mode, std::int32_t target_counts, std::uint16_t torque_limit_permille) = 0;
  virtual std::uint32_t counts_per_turn() const = 0;
  /// Distance between target and position at which a drive gives up; 0: never.
  virtual std::uint32_t following_window_counts() const = 0;
};

}  // namespace armsight::sim
