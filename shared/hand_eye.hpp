// Where does the camera see the hand? The one measurement model of the filter and of the batch calibration;
// specification §5.1 (base-frame error) and §5.4 (look covariance).
#pragma once

#include "shared/kinematics.hpp"

namespace armsight {

/// T_C_H = T_C_B Λ(q + beta) (4.4); q is the encoder reading.
Pose predict_T_C_H(const SerialChain& chain, const Pose& T_C_B, const JointVector& beta, const JointVector& q);

/// Columns of the error state: v, w (base frame, T_C_B ← T_C_B [exp(S(w)), v; 0, 1]) and the joint offsets.
inline constexpr int kErrorV = 0;
inline constexpr int kErrorW = 3;
inline constexpr int kErrorBeta = 6;
inline constexpr int kMaxState = 6 + kMaxJoints;
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxState, 1>;
using StateMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxState, kMaxState>;
using MeasurementJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxState>;

struct HandEyePrediction {
  Pose T_C_H;
  MeasurementJacobian H;  ///< ∂[p_C; log R̃]/∂[v; w; ε_β]: [R̂, −R̂S(p_Λ), R̂J_v; 0, R̂, R̂J_ω], §5.1
};
HandEyePrediction predict_hand_eye(const SerialChain& chain, const Pose& T_C_B, const JointVector& beta,
                                   const JointVector& q);

/// Applies an error state to a model: T_C_B [exp(S(w)), v; 0, 1], beta + ε_β. Leaves the revision alone.
LearnedModel apply_error_state(const LearnedModel& model, const StateVector& x);

/// What no model in force may be, wherever it comes from: filter, proposal or file. Offsets beyond 20° (specification §7.1
/// draws ±8° and drifts by 5°), a camera beyond 5 m.
inline constexpr double kMaxBeta_rad = 20.0 * kDegree;
inline constexpr double kMaxCameraDistance_m = 5.0;
bool is_plausible(const LearnedModel& model) noexcept;
/// Of [v; w; ε_β]: positive semidefinite to 1e-12, no σ beyond kMaxModelSigma, which is wider than any prior.
inline constexpr double kMaxModelSigma = 1.0;  ///< m or rad
bool is_plausible_covariance(const StateMatrix& P) noexcept;

/// The thesis' letters for a change of T_C_B (figs 8.6): T_C = T_C_B_new · T_C_B_old⁻¹ = [exp(−S(δϑ)), δt; 0, 1] (5.2).
struct CameraCorrection {
  Vector3 delta_t_m;
  Vector3 delta_theta_rad;
};
CameraCorrection camera_correction(const Pose& T_C_B_old, const Pose& T_C_B_new);

/// Covariance of the hand pose from that of the marker pose, both in C, rows position then rotation:
/// dp_H = dp_M − S(R_M p_M_H) ω (specification §5.4).
Matrix6 hand_covariance(const Pose& T_C_M, const Pose& T_H_M, const Matrix6& marker_covariance);

/// What makes a look worse than its corners say.
struct NoiseModel {
  double encoder_sigma_rad = 0.0;            ///< of one look, per joint
  double floor_position_sigma_m = 0.0;       ///< marker mount, lens, links: never trust the corners alone
  double floor_rotation_sigma_rad = 0.0;
};

using PoseColumns = Eigen::Matrix<double, 6, Eigen::Dynamic>;
/// R_k of §5.4: corners, encoders through the arm, floor. J_q: ∂[p; φ] of the pose by each joint's reading.
Matrix6 look_covariance(const Matrix6& R_vision, const Eigen::Ref<const PoseColumns>& J_q, const NoiseModel& noise);

}  // namespace armsight
