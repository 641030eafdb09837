#include "shared/hand_eye.hpp"

#include <Eigen/Cholesky>
#include <cassert>

namespace armsight {

Pose predict_T_C_H(const SerialChain& chain, const Pose& T_C_B, const JointVector& beta, const JointVector& q) {
  return T_C_B * forward_kinematics(chain, q + beta);
}

HandEyePrediction predict_hand_eye(const SerialChain& chain, const Pose& T_C_B, const JointVector& beta,
                                   const JointVector& q) {
  const HandKinematics hand = hand_kinematics(chain, q + beta);
  const Matrix3& R = T_C_B.R;
  HandEyePrediction prediction;
  prediction.T_C_H = T_C_B * hand.T_B_H;
  MeasurementJacobian& H = prediction.H;
  H.resize(6, kErrorBeta + chain.joint_count);
  H.block<3, 3>(0, kErrorV) = R;
  H.block<3, 3>(3, kErrorV).setZero();
  H.block<3, 3>(0, kErrorW).noalias() = -R * skew(hand.T_B_H.p);
  H.block<3, 3>(3, kErrorW) = R;
  for (int i = 0; i < chain.joint_count; ++i) {
    H.col(kErrorBeta + i).head<3>().noalias() = R * hand.J.col(i).head<3>();
    H.col(kErrorBeta + i).tail<3>().noalias() = R * hand.J.col(i).tail<3>();
  }
  return prediction;
}

LearnedModel apply_error_state(const LearnedModel& model, const StateVector& x) {
  assert(x.size() == kErrorBeta + model.beta.size());
  LearnedModel changed = model;
  changed.T_C_B = model.T_C_B * Pose{so3_exp(x.segment<3>(kErrorW)), x.segment<3>(kErrorV)};
  changed.beta += x.tail(model.beta.size());
  return changed;
}

bool is_plausible(const LearnedModel& model) noexcept {
  return (model.beta.array().abs() <= kMaxBeta_rad).all() && model.T_C_B.p.norm() <= kMaxCameraDistance_m;
}

bool is_plausible_covariance(const StateMatrix& P) noexcept {
  if (P.rows() != P.cols() || !P.allFinite()) return false;
  if ((P.diagonal().array() < 0.0).any() || (P.diagonal().array() > kMaxModelSigma * kMaxModelSigma).any()) return false;
  const StateMatrix lifted = P + 1e-12 * StateMatrix::Identity(P.rows(), P.cols());
  return Eigen::LLT<StateMatrix>(lifted).info() == Eigen::Success;
}

CameraCorrection camera_correction(const Pose& T_C_B_old, const Pose& T_C_B_new) {
  const Pose T_C = T_C_B_new * T_C_B_old.inverse();
  return {T_C.p, -so3_log(T_C.R)};  // the minus is (5.2)'s
}

Matrix6 hand_covariance(const Pose& T_C_M, const Pose& T_H_M, const Matrix6& marker_covariance) {
  Matrix6 G = Matrix6::Identity();
  G.block<3, 3>(0, 3) = -skew(T_C_M.R * T_H_M.inverse().p);
  return G * marker_covariance * G.transpose();
}

Matrix6 look_covariance(const Matrix6& R_vision, const Eigen::Ref<const PoseColumns>& J_q, const NoiseModel& noise) {
  Matrix6 J_J = Matrix6::Zero();
  for (Eigen::Index i = 0; i < J_q.cols(); ++i) J_J.noalias() += J_q.col(i) * J_q.col(i).transpose();
  Matrix6 R = 0.5 * (R_vision + R_vision.transpose());
  R += noise.encoder_sigma_rad * noise.encoder_sigma_rad * J_J;
  R.diagonal().head<3>().array() += noise.floor_position_sigma_m * noise.floor_position_sigma_m;
  R.diagonal().tail<3>().array() += noise.floor_rotation_sigma_rad * noise.floor_rotation_sigma_rad;
  return R;
}

}  // namespace armsight
