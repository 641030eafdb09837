// The hand's one synergy: fingers that close at a finite speed and stop on what is between them.
#pragma once

#include <functional>

#include "protocol/config.hpp"
#include "tools/sim/motor.hpp"

namespace armsight::sim {

class Fingers : public Motor {
 public:
  /// Is there something to stop on? Asked once in each close, when the fingers reach the object's width.
  using Touches = std::function<bool()>;
  Fingers(const HandConfig& hand, Touches touches);

  void step(double dt_s);
  /// 0 open … 1 closed.
  double closure() const { return closure_; }
  bool is_holding() const { return is_holding_; }

  std::int32_t position_counts() override;
  std::int16_t torque_permille() const override;
  void command(MotorMode mode, std::int32_t target_counts, std::uint16_t torque_limit_permille) override;
  std::uint32_t counts_per_turn() const override { return 32768; }
  std::uint32_t following_window_counts() const override { return 0; }

 private:
  HandConfig hand_;
  Touches touches_;
  MotorMode mode_ = MotorMode::kOff;
  double closure_ = 0.0, target_ = 0.0;
  double direction_ = 0.0;
  bool is_holding_ = false;
  double grip_permille_ = 0.0;
  double torque_limit_permille_ = 1000.0;
};

}  // namespace armsight::sim
