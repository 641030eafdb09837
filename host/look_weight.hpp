// What is a look worth? W with ‖W r‖² = rᵀ R⁻¹ r, where R is what the corners or the pose itself scatter by, and
// what makes the whole look wrong at once: encoders through the arm, and the floor (specification §5.4, calibration.md
// §4.2).
//   pose:    R = R_vision + J_q Σ_q J_qᵀ + floor                    (6 × 6)
//   corners: R = σ_px² I + G (J_q Σ_q J_qᵀ + floor) Gᵀ,  G = ∂pixels/∂pose; inverted through its six directions
#pragma once

#include "host/chain_problem.hpp"

namespace armsight::host {

class LookWeight {
 public:
  /// At this model; a look whose corners fall behind the camera weighs by its pixels alone.
  LookWeight(const ChainModel& model, const Observation& z, const NoiseModel& noise);

  template <class Derived>
  Eigen::MatrixXd operator*(const Eigen::MatrixBase<Derived>& M) const {
    if (W_.size() > 0) return W_ * M;
    if (Q_.size() == 0) return inverse_sigma_px_ * M;
    return inverse_sigma_px_ * (M - Q_ * (shrink_.asDiagonal() * (Q_.transpose() * M)));
  }

 private:
  Matrix6 pose_noise(const ChainModel& model, const Observation& z, const NoiseModel& noise, Eigen::MatrixXd* G) const;

  Eigen::MatrixXd W_;           ///< poses
  double inverse_sigma_px_ = 0.0;  ///< corners: W = (I − Q diag(shrink) Qᵀ) / σ_px
  Eigen::MatrixXd Q_;
  Eigen::VectorXd shrink_;
};

/// ‖W r‖ / sqrt(rows): 1 where the noise model is right; kFarNorm where a corner falls behind the camera.
inline constexpr double kFarNorm = 1e9;
double look_norm(const ChainModel& model, const Observation& z, const NoiseModel& noise);

/// Whitened Jacobian of the observations marked used, then of the priors: rows × layout.columns.
Eigen::MatrixXd whitened_jacobian(const ChainModel& model, const std::vector<Observation>& observations,
                                  const std::vector<char>& used, const NoiseModel& noise,
                                  const UnknownLayout& layout, bool with_priors);

}  // namespace armsight::host
