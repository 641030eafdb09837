#include "host/look_planning.hpp"

#include <algorithm>

namespace armsight::host {
namespace {

constexpr int kOutOfViewTries = 4000;
constexpr double kOutOfViewMargin_px = 120.0;  // half a hand at working distance

// Could the camera see something of the arm around this point?
bool is_near_picture(const PinholeView& view, const Vector3& p_C) {
  if (p_C.z() <= 0.02) return false;
  const double x = view.cx_px + view.fx_px * p_C.x() / p_C.z();
  const double y = view.cy_px + view.fy_px * p_C.y() / p_C.z();
  const double m = kOutOfViewMargin_px;
  return x > -m && x < view.width_px + m && y > -m && y < view.height_px + m;
}

}  // namespace

PinholeView view_of(const Intrinsics& k) {
  return {static_cast<double>(k.width), static_cast<double>(k.height), k.fx, k.fy, k.cx, k.cy};
}

PlanProblem plan_problem(HostIo& io, const Pose& T_C_B, const StateMatrix& P, double margin_rad) {
  const ArmModel& arm = io.robot().arm;
  PlanProblem problem;
  problem.chain = arm.chain;
  const Eigen::ArrayXd range = arm.limits.max_rad.array() - arm.limits.min_rad.array();
  const Eigen::ArrayXd margin = range.min(margin_rad / 0.45) * 0.45;
  problem.min_rad = arm.limits.min_rad.array() + margin;
  problem.max_rad = arm.limits.max_rad.array() - margin;
  problem.T_C_B = T_C_B;
  problem.T_H_M = arm.T_H_M;
  problem.view = view_of(io.camera().intrinsics());
  problem.marker_side_m = io.robot().hand_marker.side_m;
  problem.noise.encoder_sigma_rad = io.robot().filter.encoder_sigma_rad;
  problem.noise.floor_position_sigma_m = io.robot().filter.floor_position_sigma_m;
  problem.noise.floor_rotation_sigma_rad = io.robot().filter.floor_rotation_sigma_rad;
  problem.collision = io.robot().collision.model;
  problem.P = P;
  return problem;
}

StateMatrix wide_prior(const EkfOptions& options, int joints) {
  StateMatrix P = StateMatrix::Zero(kErrorBeta + joints, kErrorBeta + joints);
  P.diagonal().segment<3>(kErrorV).setConstant(options.prior_position_sigma_m * options.prior_position_sigma_m);
  P.diagonal().segment<3>(kErrorW).setConstant(options.prior_rotation_sigma_rad * options.prior_rotation_sigma_rad);
  P.diagonal().tail(joints).setConstant(options.prior_beta_sigma_rad * options.prior_beta_sigma_rad);
  P(kErrorBeta, kErrorBeta) = options.prior_beta1_sigma_rad * options.prior_beta1_sigma_rad;
  return P;
}

std::vector<JointVector> postures_out_of_view(const PlanProblem& problem, const JointVector& q_start, int count) {
  std::vector<JointVector> found;
  for (int i = 0; i < kOutOfViewTries; ++i) {
    const JointVector q = spread_posture(problem.min_rad, problem.max_rad, i);
    const Pose T_C_H = problem.T_C_B * forward_kinematics(problem.chain, q);
    if (is_near_picture(problem.view, T_C_H.p)) continue;
    if (is_near_picture(problem.view, T_C_H * problem.T_H_M.p)) continue;
    if (!is_too_near(problem, q)) found.push_back(q);
  }
  const auto travel = [&](const JointVector& q) { return (q - q_start).lpNorm<Eigen::Infinity>(); };
  std::stable_sort(found.begin(), found.end(), [&](const auto& a, const auto& b) { return travel(a) < travel(b); });
  if (static_cast<int>(found.size()) > count) found.resize(static_cast<std::size_t>(count));
  return found;
}

}  // namespace armsight::host
