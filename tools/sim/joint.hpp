// One true joint behind a position drive: follows its target first-order within speed and acceleration, brakes on a
// quick-stop ramp, stops at the mechanical ends.
#pragma once

#include "protocol/config.hpp"
#include "tools/sim/motor.hpp"
#include "tools/sim/smooth_error.hpp"

namespace armsight::sim {

struct JointTruth {
  DriveConfig drive;
  double beta_rad = 0.0;
  SmoothError encoder_error, servo_residual;
  double jitter_rad = 0.0;
  double min_rad = 0.0, max_rad = 0.0;  ///< mechanical ends, real angles
  Random jitter{0, 0};
};

class Joint : public Motor {
 public:
  Joint(const JointTruth& truth, double start_rad);

  void step(double dt_s);
  /// The zero creeps there within a tenth of a second: offsets drift, they do not jump (a jump is an encoder fault).
  void set_beta(double beta_rad) { beta_goal_rad_ = beta_rad; }
  double q_rad() const { return q_; }
  double speed_rad_s() const { return speed_; }

  std::int32_t position_counts() override;
  std::int16_t torque_permille() const override;
  void command(MotorMode mode, std::int32_t target_counts, std::uint16_t torque_limit_permille) override;
  std::uint32_t counts_per_turn() const override;
  std::uint32_t following_window_counts() const override;

 private:
  double reading_rad() const { return q_ - truth_.beta_rad - truth_.encoder_error.at(q_); }
  double counts_to_rad(double counts) const;
  double wanted_speed() const;

  JointTruth truth_;
  double beta_goal_rad_;
  double q_, speed_ = 0.0;
  MotorMode mode_ = MotorMode::kOff;
  double target_reading_rad_ = 0.0;
};

}  // namespace armsight::sim
