// Where should the search begin? Closed forms for the mounts of host/chain_problem.hpp, no guess needed (F-C2).
// One mount known: robust chordal mean of the other. Both unknown, T_C_M · V = X · G: our own linear AX = ZB and
// OpenCV's (SHAH, PARK, HORAUD, DANIILIDIS); none is trusted alone, all are handed out as starts to be scored.
#pragma once

#include <vector>

#include "host/chain_problem.hpp"

namespace armsight::host {

/// Starts, the model as it came first. Observations need poses (corners: from PnP).
std::vector<ChainModel> closed_form_starts(const ChainModel& model, const std::vector<Observation>& observations);

/// Chordal mean of the rotations (SVD) and mean of the positions of the inner 70 %; empty input is not allowed.
Pose robust_mean(const std::vector<Pose>& poses);

/// X of T_C_M,i V = X G_i by one linear system for both rotations, then one for both positions.
Pose linear_robot_world(const std::vector<Pose>& T_C_M, const std::vector<Pose>& G);

}  // namespace armsight::host
