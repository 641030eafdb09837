// The exact posture for a goal of an arm with a spherical shoulder, an elbow and a forearm roll (the default arm): closed
// form over the elbow's swivel about the line from shoulder to hand, joint limits included; controller.md §6.2.
//
// The hand's position fixes the elbow's angle. What is left are the swivel ψ and the forearm roll q5, and the trace of
// R_goalᵀ R(ψ, q5) is bilinear in (1, cos ψ, sin ψ) and (1, cos q5, sin q5): it has one maximum on the torus, one on every
// edge of the limits. So the best posture is among at most 16 per branch of shoulder and elbow, and none is searched for.
#pragma once

#include <optional>

#include "shared/inverse_kinematics.hpp"
#include "shared/swivel_arm.hpp"

namespace armsight {

/// As solve_ik, and more: of all postures within [min, max] that reach the position, none has a smaller orientation
/// error; of those that have it, the nearest to `seed` is given. `arm` is that of `chain`. The limits are kept as they
/// stand, without a margin.
std::optional<IkSolution> solve_swivel_ik(const SerialChain& chain, const SwivelArm& arm, const JointVector& min_rad,
                                          const JointVector& max_rad, const Pose& T_B_G, const JointVector& seed,
                                          double position_tolerance_m);

}  // namespace armsight
