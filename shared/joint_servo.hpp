// Joint-space motion: from where the arm is to a target posture, all joints arriving together, inside position, speed,
// acceleration and jerk limits at all times, and able to stop inside them at any time. rad, s. No heap, no throw.
//
// A trip that starts at rest runs on the straight line between the postures (limits shared out in proportion), and a
// stop on it stays on that line; one that starts in motion stretches the quicker joints' cruise.
#pragma once

#include <array>

#include "shared/arm_model.hpp"
#include "shared/jerk_profile.hpp"

namespace armsight {

struct JointSetpoint {
  JointVector q_rad, speed_rad_s, acceleration_rad_s2;
};

class JointServo {
 public:
  explicit JointServo(const JointLimits& limits);

  /// Starts at rest at q (target := actual).
  void reset(const JointVector& q_rad);
  /// From now on, also in motion. Lower acceleration or jerk come into force, joint by joint, when the arm can stop with
  /// them inside its position limits and coast inside its speed limit; until then that joint brakes with what it has.
  void set_limits(const JointLimits& limits);
  /// In force.
  const JointLimits& limits() const { return limits_; }

  /// One step of dt_s towards a posture (clamped into the limits). speed_scale in (0, 1].
  const JointSetpoint& step_towards(const JointVector& target_rad, double speed_scale, double dt_s);
  /// One step of dt_s along wanted joint speeds (the pose servo's), limited like everything else.
  const JointSetpoint& step_with_speed(const JointVector& speed_rad_s, double dt_s);
  /// One step of braking; at rest it holds.
  const JointSetpoint& step_to_rest(double dt_s);

  const JointSetpoint& setpoint() const { return setpoint_; }
  bool is_at_rest() const;
  /// Where a stop that begins now would lead, `part` of its time later: 1 is its end.
  JointVector stopping_rad(double part) const;
  /// How far from q_rad each joint comes at most, from now to the end of that stop.
  JointVector stopping_excursion_rad(const JointVector& q_rad) const;

 private:
  AxisState axis(Eigen::Index i) const;
  AxisLimits axis_limits(Eigen::Index i, double speed_scale = 1.0) const;
  void put(Eigen::Index i, const AxisState& x);
  void adopt_limits();
  bool may_adopt(Eigen::Index i, const AxisLimits& lower) const;
  void plan_trip(const JointVector& target, double speed_scale);
  void plan_on_a_line(const JointVector& way, double speed_scale);
  void plan_in_motion(const JointVector& target, double speed_scale);
  AxisState step_axis_with_speed(Eigen::Index i, double wanted_rad_s, double dt_s) const;

  JointLimits limits_, wanted_limits_;
  std::array<bool, kMaxJoints> waits_{};           ///< for its wanted acceleration and jerk
  std::array<AxisLimits, kMaxJoints> trip_limits_{};
  JointVector trip_target_;
  double trip_scale_ = 0.0;                        ///< 0: no trip is planned
  JointSetpoint setpoint_;
};

}  // namespace armsight
