// Joint-space motion: from where the arm is to a target posture, all joints arriving together, inside speed,
// acceleration and position limits in every step, and able to stop at any time. rad, s. No heap, no throw.
#pragma once

#include "shared/arm_model.hpp"

namespace armsight {

struct JointSetpoint {
  JointVector q_rad, speed_rad_s, acceleration_rad_s2;
};

class JointServo {
 public:
  explicit JointServo(const JointLimits& limits);

  /// Starts at rest at q (target := actual).
  void reset(const JointVector& q_rad);
  /// One step of dt_s towards a posture (clamped into the limits). speed_scale in (0, 1].
  const JointSetpoint& step_towards(const JointVector& target_rad, double speed_scale, double dt_s);
  /// One step of dt_s along wanted joint speeds (the pose servo's), limited like everything else.
  const JointSetpoint& step_with_speed(const JointVector& speed_rad_s, double dt_s);
  /// One step of braking; at rest it holds.
  const JointSetpoint& step_to_rest(double dt_s);

  const JointSetpoint& setpoint() const { return setpoint_; }
  bool is_at_rest() const;

 private:
  void move_joint(Eigen::Index i, double wanted_rad_s, double dt_s);

  JointLimits limits_;
  JointSetpoint setpoint_;
};

}  // namespace armsight
