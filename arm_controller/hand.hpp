// The hand's one synergy: closure 0 open … 1 closed, led there at a steady pace so that CSP never jumps.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace armsight::arm {

class Hand {
 public:
  static constexpr double kFullStroke_s = 1.0;

  explicit Hand(double period_s) noexcept : period_s_(period_s) {}

  void stand_at(double closure) noexcept { target_ = command_ = std::clamp(closure, 0.0, 1.0); }
  void order(double closure, std::uint16_t force_limit_permille, double speed_scale = 1.0) noexcept {
    target_ = closure;
    speed_scale_ = speed_scale;
    force_limit_permille_ = force_limit_permille;
    quiet_s_ = 0.0;
  }
  /// Stops where the fingers are.
  void stop() noexcept { target_ = command_; }

  void step(double measured_closure) noexcept {
    const double largest = speed_scale_ * period_s_ / kFullStroke_s;
    command_ += std::clamp(target_ - command_, -largest, largest);
    slow_ += (measured_closure - slow_) * std::min(1.0, period_s_ / kLag_s);
    const bool is_quiet = command_ == target_ && std::abs(measured_closure - slow_) < kQuiet;
    quiet_s_ = is_quiet ? quiet_s_ + period_s_ : 0.0;
  }

  double command() const noexcept { return command_; }
  double target() const noexcept { return target_; }
  std::uint16_t force_limit_permille() const noexcept { return force_limit_permille_; }
  bool is_moving() const noexcept { return quiet_s_ < kQuietTime_s; }

 private:
  static constexpr double kLag_s = 0.1, kQuiet = 0.004, kQuietTime_s = 0.1;
  double period_s_;
  double target_ = 0.0, command_ = 0.0, slow_ = 0.0, quiet_s_ = 1.0, speed_scale_ = 1.0;
  std::uint16_t force_limit_permille_ = 1000;
};

}  // namespace armsight::arm
