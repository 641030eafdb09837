#include "tools/sim/fingers.hpp"

#include <algorithm>
#include <cmath>

namespace armsight::sim {

namespace {

constexpr double kStrokeTime_s = 0.8;
constexpr double kContactClosure = 0.55;      // the object's width between the fingers
constexpr double kFriction_permille = 60.0;   // of fingers that move freely
constexpr double kGripTime_s = 0.05;          // in which the effort rises after contact

}  // namespace

Fingers::Fingers(const HandConfig& hand, Touches touches) : hand_(hand), touches_(std::move(touches)) {}

void Fingers::step(double dt_s) {
  const double wanted = mode_ == MotorMode::kFollow ? target_ : closure_;
  const double step = std::clamp(wanted - closure_, -dt_s / kStrokeTime_s, dt_s / kStrokeTime_s);
  const double next = closure_ + step;
  if (step < 0.0) is_holding_ = false;
  const bool reaches_contact = !is_holding_ && step > 0.0 && closure_ < kContactClosure && next >= kContactClosure;
  if (reaches_contact && touches_()) is_holding_ = true;
  if (is_holding_ && next >= kContactClosure) {
    closure_ = std::nextafter(kContactClosure, 0.0);
    const double wanted_grip = mode_ == MotorMode::kOff ? 0.0 : torque_limit_permille_;
    grip_permille_ += (wanted_grip - grip_permille_) * std::min(1.0, dt_s / kGripTime_s);
    direction_ = 0.0;
    return;
  }
  closure_ = next;
  grip_permille_ = 0.0;
  direction_ = step > 1e-9 ? 1.0 : step < -1e-9 ? -1.0 : 0.0;
}

std::int32_t Fingers::position_counts() {
  return hand_.open_counts +
         static_cast<std::int32_t>(std::lround(closure_ * (hand_.closed_counts - hand_.open_counts)));
}

std::int16_t Fingers::torque_permille() const {
  if (is_holding_) return static_cast<std::int16_t>(std::lround(grip_permille_));
  return static_cast<std::int16_t>(std::lround(direction_ * std::min(kFriction_permille, torque_limit_permille_)));
}

void Fingers::command(MotorMode mode, std::int32_t target_counts, std::uint16_t torque_limit_permille) {
  mode_ = mode;
  const double stroke = hand_.closed_counts - hand_.open_counts;
  target_ = std::clamp((target_counts - hand_.open_counts) / stroke, 0.0, 1.0);
  torque_limit_permille_ = torque_limit_permille;
}

}  // namespace armsight::sim
