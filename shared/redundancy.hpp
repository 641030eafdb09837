// A chain of more than six joints can keep its hand where it is and move the rest. Where to? Away from joint limits and
// from singular postures. Real angles, rad, m. No heap, no throw.
#pragma once

#include "shared/kinematics.hpp"

namespace armsight {

/// A chain whose hand's six freedoms leave some of its joints'.
inline bool is_redundant(const SerialChain& chain) { return chain.joint_count > 6; }

/// Least singular value of J with its rows of position over the links' length: how slowly the hand moves or turns in its
/// worst direction for joints turning at 1 rad/s; 0 at a singular posture, and for fewer than six joints.
double pose_manipulability(const SerialChain& chain, const Jacobian& J);

/// 0 where no joint is near a limit and the posture is far from singular; a joint at its limit adds 1, a singular
/// posture 1.
double discomfort(const SerialChain& chain, const JointVector& q, const JointVector& min_rad,
                  const JointVector& max_rad);

/// Where joints near a limit should go, half the negative gradient of their part of the discomfort: 1/rad.
JointVector limit_relief(const JointVector& q, const JointVector& min_rad, const JointVector& max_rad);

/// From q (inside the limits) along the postures with the very same hand pose, downhill in discomfort: an answer for the
/// hand that q is one for, at most as uncomfortable. Where nothing is left to choose: q.
JointVector most_comfortable(const SerialChain& chain, const JointVector& q, const JointVector& min_rad,
                             const JointVector& max_rad);

}  // namespace armsight
