// Is this chain an arm with a spherical shoulder, an elbow and a forearm roll (as the default arm), and what are its lengths?
// Then the posture for a goal has a closed form: swivel_ik.
#pragma once

#include <array>
#include <optional>

#include "shared/arm_model.hpp"

namespace armsight {

/// The geometry of such an arm, in B with all joints at zero. Axes are unit vectors.
struct SwivelArm {
  std::array<Vector3, 5> axis;
  Vector3 shoulder;                 ///< where the axes of joints 1, 2 and 3 meet
  Vector3 upper_arm, forearm;       ///< directions shoulder → elbow, elbow → hand
  double upper_arm_m = 0.0, forearm_m = 0.0;
  double elbow_at_zero_rad = 0.0;   ///< from upper arm to forearm about axis 4
  Matrix3 R_B_H;                    ///< the hand
};

/// The arm's geometry, or nullopt where the chain has another: five joints, axes 1 ⟂ 2 ⟂ 3 through one point, axis 4
/// ⟂ 3 through the elbow on axis 3, axis 5 ⟂ 4 through elbow and hand. Held to 1e-9 (m, rad): a chain with link errors
/// has another geometry.
std::optional<SwivelArm> swivel_arm(const SerialChain& chain);

}  // namespace armsight
