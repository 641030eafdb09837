// What holds the arm up: joint torques against gravity, by one recursion over the links (specification F-K5).
// kg, m, N·m, m/s². Frame i is the chain's frame after joint i. No heap.
#pragma once

#include <array>

#include "shared/arm_model.hpp"

namespace armsight {

struct LinkMass {
  double mass_kg = 0.0;
  Vector3 com_m = Vector3::Zero();  ///< in frame i
};
using LinkMasses = std::array<LinkMass, kMaxJoints>;

/// τ_j = −Σ_{i≥j} m_i g · (z_j × (p_i − o_j)), the gradient of the potential energy: what the joints must give for the arm
/// to rest at q (real angles). gravity_m_s2 in B, pointing down.
JointVector gravity_torque(const SerialChain& chain, const LinkMasses& links, const Vector3& gravity_m_s2,
                           const JointVector& q);
/// −Σ m_i g · p_i, in J.
double potential_energy(const SerialChain& chain, const LinkMasses& links, const Vector3& gravity_m_s2,
                        const JointVector& q);

}  // namespace armsight
