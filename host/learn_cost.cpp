// The looks as each cost of host/batch_calibration.hpp sees them.
#include <Eigen/Cholesky>

#include "host/batch_calibration.hpp"

namespace armsight::host {
namespace {

constexpr double kThesisSigma = 1e-3;  // any: (4.6) has no weights, and the solver likes numbers near 1

/// The pose that the corners give, with the covariance of σ_px.
Observation as_pose(const ChainModel& model, const Observation& z) {
  if (!z.has_corners()) return z;
  Observation pose = z;
  pose.points_M.clear();
  pose.pixels.clear();
  Matrix6 information = Matrix6::Zero();
  for (const Vector3& point : z.points_M) {
    const Vector3 arm = z.T_C_M.R * point;
    const auto projected = project_with_jacobian(model.camera, z.T_C_M.p + arm);
    if (!projected) continue;
    Eigen::Matrix<double, 2, 6> G;
    G << projected->J, -projected->J * skew(arm);
    information += G.transpose() * G / (z.sigma_px * z.sigma_px);
  }
  pose.R_vision = information.ldlt().solve(Matrix6::Identity());
  return pose;
}

Observation as_thesis(const ChainModel& model, const Observation& z) {
  Observation pose = as_pose(model, z);
  pose.by_half_angle = true;
  pose.R_vision = Matrix6::Identity() * kThesisSigma * kThesisSigma;
  return pose;
}

}  // namespace

std::vector<Observation> observations_for(LearnCost cost, const ChainModel& model,
                                          const std::vector<Observation>& observations) {
  if (cost == LearnCost::kLikelihood || cost == LearnCost::kPixels) return observations;
  std::vector<Observation> seen;
  for (const auto& z : observations) {
    seen.push_back(cost == LearnCost::kThesis ? as_thesis(model, z) : as_pose(model, z));
  }
  return seen;
}

}  // namespace armsight::host
