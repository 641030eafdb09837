#include "host/visibility.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace armsight::host {
namespace {

std::array<Vector3, 4> corners(double side_m) {
  const double h = 0.5 * side_m;
  return {Vector3(-h, h, 0), Vector3(h, h, 0), Vector3(h, -h, 0), Vector3(-h, -h, 0)};
}

constexpr double kNearestDepth = 0.02;  // m: nearer than this nothing is in focus, and the projection blows up

}  // namespace

double marker_tilt_rad(const Pose& T_C_M) {
  const double cosine = -T_C_M.R.col(2).dot(T_C_M.p) / T_C_M.p.norm();
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

bool is_well_visible(const PinholeView& view, const ViewLimits& limits, const Pose& T_C_M, double side_m) {
  const double distance = T_C_M.p.norm();
  if (!(distance >= limits.min_distance_m && distance <= limits.max_distance_m)) return false;
  const double tilt = marker_tilt_rad(T_C_M);
  if (!(tilt >= limits.min_tilt_rad && tilt <= limits.max_tilt_rad)) return false;
  for (const Vector3& corner : corners(side_m)) {
    const Vector3 p = T_C_M * corner;
    if (p.z() < kNearestDepth) return false;
    const double x = view.cx_px + view.fx_px * p.x() / p.z();
    const double y = view.cy_px + view.fy_px * p.y() / p.z();
    const double m = limits.image_margin_px;
    if (!(x >= m && x <= view.width_px - m && y >= m && y <= view.height_px - m)) return false;
  }
  return true;
}

std::optional<Matrix6> marker_covariance(const PinholeView& view, const Pose& T_C_M, double side_m,
                                         double corner_sigma_px) {
  Matrix6 information = Matrix6::Zero();
  for (const Vector3& corner : corners(side_m)) {
    const Vector3 p = T_C_M * corner;
    if (p.z() < kNearestDepth) return std::nullopt;
    Eigen::Matrix<double, 2, 3> J_px_p;
    J_px_p << view.fx_px / p.z(), 0, -view.fx_px * p.x() / (p.z() * p.z()),  //
        0, view.fy_px / p.z(), -view.fy_px * p.y() / (p.z() * p.z());
    Eigen::Matrix<double, 3, 6> J_p_pose;  // p = p_M + exp(ω) R c: dp = dp_M − S(R c) ω
    J_p_pose << Matrix3::Identity(), -skew(T_C_M.R * corner);
    const Eigen::Matrix<double, 2, 6> J = J_px_p * J_p_pose;
    information += J.transpose() * J;
  }
  const Eigen::LLT<Matrix6> llt(information);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return Matrix6(corner_sigma_px * corner_sigma_px * llt.solve(Matrix6::Identity()));
}

std::optional<StateMatrix> look_information(const SerialChain& chain, const Pose& T_C_B, const Pose& T_H_M,
                                            const PinholeView& view, double side_m, const LookNoise& noise,
                                            const JointVector& q_real) {
  const JointVector zero = JointVector::Zero(q_real.size());
  const HandEyePrediction predicted = predict_hand_eye(chain, T_C_B, zero, q_real);
  const Pose T_C_M = predicted.T_C_H * T_H_M;
  const std::optional<Matrix6> P_M = marker_covariance(view, T_C_M, side_m, noise.corner_sigma_px);
  if (!P_M) return std::nullopt;

  const Matrix6 R =
      look_covariance(hand_covariance(T_C_M, T_H_M, *P_M), predicted.H.rightCols(q_real.size()), noise);
  const Eigen::LLT<Matrix6> llt(R);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const MeasurementJacobian whitened = llt.matrixL().solve(predicted.H);
  return StateMatrix(whitened.transpose() * whitened);
}

}  // namespace armsight::host
