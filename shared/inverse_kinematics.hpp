// Which posture brings the hand there? Position exact, orientation as near as the joints allow, limits kept.
// Closed form where the arm's geometry allows it (swivel_ik), else damped least squares from several starts; the answer
// carries its own certificate, computed by forward kinematics.
#pragma once

#include <optional>

#include "shared/kinematics.hpp"

namespace armsight {

struct IkOptions {
  double position_tolerance_m = 1e-5;
  double orientation_weight_m = 0.05;  ///< metres an orientation error of 1 rad weighs
  int starts = 48;                     ///< at most: first from `seed`, then a fixed low-discrepancy sequence
  int iterations = 100;
  double limit_margin_rad = 0.01;      ///< kept clear of both limits
  bool seeks_comfort = true;           ///< of a redundant chain: away from limits and singular postures
  int max_evaluations = 8000;          ///< of the kinematics: bounds the time, the best until then is the answer
};

struct IkSolution {
  JointVector q;                    ///< real angles, inside the limits
  double position_error_m = 0.0;    ///< certificate, from forward kinematics
  double orientation_error_rad = 0.0;
  int evaluations = 0;              ///< of the kinematics in a search, or postures tried in closed form
};

/// Best posture for T_B_G: nullopt when no start reaches the position inside [min, max] (limits of real angles).
/// Among the postures found (in closed form: among all there are): least orientation error, then nearest to `seed`; from
/// there a redundant chain moves on, the hand where it is, to where it is comfortable. Deterministic.
std::optional<IkSolution> solve_ik(const SerialChain& chain, const JointVector& min_rad, const JointVector& max_rad,
                                   const Pose& T_B_G, const JointVector& seed, const IkOptions& options = {});

}  // namespace armsight
