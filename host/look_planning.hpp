// The plan problem as the running session sees it: robot file, camera, and a model with its covariance.
#pragma once

#include "host/host_io.hpp"
#include "host/pose_planner.hpp"

namespace armsight::host {

PinholeView view_of(const Intrinsics& intrinsics);
/// Limits less margin_rad on both sides; joints too narrow for it keep a tenth of their range.
PlanProblem plan_problem(HostIo& io, const Pose& T_C_B, const StateMatrix& P, double margin_rad);
/// P of the filter's wide prior as the robot file states it.
StateMatrix wide_prior(const EkfOptions& options, int joints);
/// Postures whose marker and elbow stay outside the picture, nearest to q_start first, at most `count`.
std::vector<JointVector> postures_out_of_view(const PlanProblem& problem, const JointVector& q_start, int count);

}  // namespace armsight::host
