// Where is the hand? Forward kinematics and the geometric Jacobian of a serial chain; specification §4.2.
// q[i] is the real angle (reading + beta) of joint i about its own z axis, rad; size joint_count everywhere. Metres. No heap.
#pragma once

#include <limits>

#include "shared/arm_model.hpp"

namespace armsight {

/// Λ(q) = T_B_H, pose of the hand in the base (4.4).
Pose forward_kinematics(const SerialChain& chain, const JointVector& q);

struct HandKinematics {
  Pose T_B_H;
  Jacobian J;  ///< ∂/∂q of the hand's origin, in B: rows 0–2 linear (m/rad), 3–5 angular (rad/rad)
};
HandKinematics hand_kinematics(const SerialChain& chain, const JointVector& q);

/// Smallest singular value of the 3 × n position Jacobian over the arm's reach, 0 at a singularity (controller.md §6.2).
double position_manipulability(const SerialChain& chain, const JointVector& q);
/// The same where the Jacobian is known; or, sooner, some value between `enough` and it.
double position_manipulability(const SerialChain& chain, const Jacobian& J,
                               double enough = std::numeric_limits<double>::infinity());
/// Upper bound of |p| over all postures: the sum of the link lengths.
double reach_m(const SerialChain& chain);

}  // namespace armsight
