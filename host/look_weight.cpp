#include "host/look_weight.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace armsight::host {
namespace {

bool is_silent(const NoiseModel& noise) {
  return noise.encoder_sigma_rad == 0.0 && noise.floor_position_sigma_m == 0.0 &&
         noise.floor_rotation_sigma_rad == 0.0;
}

void place(const UnknownLayout& layout, const LookUnknowns& columns, const Eigen::MatrixXd& look, Eigen::Index row,
           Eigen::MatrixXd& J) {
  for (const auto& block : columns.blocks) {
    const UnknownBlock* global = layout.find(block.kind, block.index);
    if (global) J.block(row, global->column, look.rows(), block.size) = look.middleCols(block.column, block.size);
  }
}

}  // namespace

/// Covariance of [p; φ] in C that the whole look shares; G of a look with corners.
Matrix6 LookWeight::pose_noise(const ChainModel& model, const Observation& z, const NoiseModel& noise,
                               Eigen::MatrixXd* G) const {
  const LookUnknowns columns = look_unknowns(model, z.target);
  const PosePrediction prediction = predict_T_C_M(model, z, columns);
  if (G) {
    const auto residual = residual_of(model, z, columns);
    *G = residual ? residual->G : Eigen::MatrixXd();
  }
  const auto joints = static_cast<Eigen::Index>(columns.joints.size());
  const Matrix6 own = z.has_corners() ? Matrix6(Matrix6::Zero()) : z.R_vision;
  return look_covariance(own, prediction.J.middleCols(LookUnknowns::kFirstOffset, joints), noise);
}

LookWeight::LookWeight(const ChainModel& model, const Observation& z, const NoiseModel& noise) {
  if (!z.has_corners()) {
    const Matrix6 L = pose_noise(model, z, noise, nullptr).llt().matrixL();
    W_ = L.triangularView<Eigen::Lower>().solve(Matrix6::Identity());
    return;
  }
  inverse_sigma_px_ = 1.0 / z.sigma_px;
  if (is_silent(noise)) return;
  Eigen::MatrixXd G;
  const Matrix6 F = pose_noise(model, z, noise, &G);
  if (G.size() == 0) return;
  const Eigen::SelfAdjointEigenSolver<Matrix6> shared(F);
  const Eigen::MatrixXd U = G * (shared.eigenvectors() * shared.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal());
  const Eigen::SelfAdjointEigenSolver<Matrix6> gram(Matrix6(U.transpose() * U));
  const double least = 1e-12 * std::max(gram.eigenvalues()[5], z.sigma_px * z.sigma_px);
  Q_.setZero(U.rows(), 6);
  shrink_.setZero(6);
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double value = gram.eigenvalues()[k];
    if (value <= least) continue;
    Q_.col(k) = U * gram.eigenvectors().col(k) / std::sqrt(value);
    shrink_[k] = 1.0 - z.sigma_px / std::sqrt(z.sigma_px * z.sigma_px + value);
  }
}

double look_norm(const ChainModel& model, const Observation& z, const NoiseModel& noise) {
  const auto r = residual_only(model, z);
  if (!r) return kFarNorm;
  return (LookWeight(model, z, noise) * *r).norm() / std::sqrt(static_cast<double>(z.rows()));
}

Eigen::MatrixXd whitened_jacobian(const ChainModel& model, const std::vector<Observation>& observations,
                                  const std::vector<char>& used, const NoiseModel& noise,
                                  const UnknownLayout& layout, bool with_priors) {
  const Eigen::Index priors = with_priors ? prior_rows(model) : 0;
  Eigen::Index rows = priors;
  for (std::size_t i = 0; i < observations.size(); ++i) rows += used[i] ? observations[i].rows() : 0;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, layout.columns);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const Observation& z = observations[i];
    const LookUnknowns columns = look_unknowns(model, z.target);
    const auto residual = residual_of(model, z, columns);
    if (residual) place(layout, columns, LookWeight(model, z, noise) * residual->J, row, J);
    row += z.rows();
  }
  if (!with_priors) return J;
  Eigen::VectorXd r;
  Eigen::MatrixXd J_priors;
  prior_residuals(model, layout, r, J_priors);
  J.bottomRows(priors) = J_priors;
  return J;
}

}  // namespace armsight::host
