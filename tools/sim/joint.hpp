// One true joint behind a position drive: follows its target first-order within speed and acceleration, brakes on a
// quick-stop ramp, stops at the mechanical ends. Behind an impedance drive it is an inertia that the drive's torque and
// gravity turn; without power a brake holds it. A soft joint's drive turns a spring whose other end, the link, is bent
// away by its load and is what the encoder sees.
#pragma once

#include <cmath>

#include "protocol/config.hpp"
#include "shared/spring.hpp"
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
  Spring spring{};                      ///< k_Nm = 0: stiff
};

/// What is wrong with an encoder: readings off by so much, or no longer changing, or trembling (uniform, ±).
struct EncoderFault {
  double offset_rad = 0.0;
  bool is_frozen = false;
  double tremble_rad = 0.0;
};

class Joint : public Motor {
 public:
  /// The link stands at start_rad under load_Nm: what it needs to be held, gravity's share.
  Joint(const JointTruth& truth, double start_rad, double load_Nm = 0.0);

  void step(double dt_s, double load_Nm = 0.0);
  /// The zero creeps there within a tenth of a second: offsets drift, they do not jump (a jump is an encoder fault).
  void set_beta(double beta_rad) { beta_goal_rad_ = beta_rad; }
  /// The drive's own loop sees it, too.
  void set_encoder_fault(const EncoderFault& fault);
  /// Something is in the way beyond these: it gives a little where the drive presses.
  void block(double min_rad, double max_rad);
  double q_rad() const { return motor_ + bend_; }
  double speed_rad_s() const { return speed_; }

  std::int32_t position_counts() override;
  std::int16_t torque_permille() const override;
  void command(MotorMode mode, std::int32_t target_counts, std::uint16_t torque_limit_permille) override;
  void command(const Impedance& wanted) override;
  void set_stiffness(std::uint16_t permille) override { preset_goal_ = 1e-3 * permille; }
  std::uint32_t counts_per_turn() const override;
  std::uint32_t following_window_counts() const override;

 private:
  double reading_rad() const { return seen_rad(q_rad()); }
  double motor_reading_rad() const { return seen_rad(motor_); }
  double seen_rad(double place) const;
  double counts_to_rad(double counts) const;
  double wanted_speed() const;
  double impedance_torque() const;
  void step_impedance(double dt_s, double load_Nm);
  void bend(double dt_s, double load_Nm);
  double behind_rad() const;
  void press_on_obstacle();

  JointTruth truth_;
  EncoderFault fault_;
  double frozen_rad_ = 0.0;
  double beta_goal_rad_;
  double free_from_rad_ = -HUGE_VAL, free_to_rad_ = HUGE_VAL;  ///< obstacles are beyond
  double motor_, speed_ = 0.0;  ///< the drive's end; of a stiff joint the link itself
  double bend_ = 0.0;           ///< link − motor
  MotorMode mode_ = MotorMode::kOff;
  double target_reading_rad_ = 0.0;
  Impedance impedance_{};
  double preset_ = 1.0, preset_goal_ = 1.0;  ///< share of the description's spring preset
};

}  // namespace armsight::sim
