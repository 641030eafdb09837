// Pose-based visual servoing in joint space on the corrected model: pose error → limited joint speeds;
// controller.md §6.3 and thesis §7.2.1. Position first, orientation weighted, damped near singular postures,
// speeds inside a box. No heap, no throw.
#pragma once

#include "shared/kinematics.hpp"

namespace armsight {

struct PoseServoOptions {
  double gain_per_s = 4.0;
  double orientation_weight_m = 0.05;
  double damping = 0.01;           ///< λ at a singular posture, 0 where position_manipulability is above 0.1
};

/// Joint speeds that reduce pose_error(T_B_G, Λ(q_real)); each within ±max_speed_rad_s and such that no joint passes
/// [min_rad, max_rad] in dt_s. What a redundant chain has left over goes away from the limits. q_real = reading + beta.
JointVector pose_servo_speeds(const SerialChain& chain, const JointVector& q_real, const Pose& T_B_G,
                              const JointVector& min_rad, const JointVector& max_rad,
                              const JointVector& max_speed_rad_s, double dt_s, const PoseServoOptions& options);

}  // namespace armsight
