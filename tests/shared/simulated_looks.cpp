#include "tests/shared/simulated_looks.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "tests/shared/default_arm.hpp"

namespace armsight::test {
namespace {

constexpr double kFocal_px = 700.0;
constexpr double kHalfSide_m = 0.025;

using Corners = Eigen::Matrix<double, 8, 1>;

std::array<Vector3, 4> corner_points() {
  constexpr double h = kHalfSide_m;
  return {Vector3(-h, h, 0), Vector3(h, h, 0), Vector3(h, -h, 0), Vector3(-h, -h, 0)};
}

Corners project(const Pose& T_C_M) {
  Corners corners;
  Eigen::Index row = 0;
  for (const Vector3& point : corner_points()) {
    const Vector3 p = T_C_M * point;
    corners.segment<2>(row) = kFocal_px * p.head<2>() / p.z();
    row += 2;
  }
  return corners;
}

Eigen::Matrix<double, 8, 6> projection_jacobian(const Pose& T_C_M) {
  Eigen::Matrix<double, 8, 6> J;
  Eigen::Index row = 0;
  for (const Vector3& point : corner_points()) {
    const Vector3 p = T_C_M * point;
    Eigen::Matrix<double, 2, 3> D;
    D << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
    J.block<2, 3>(row, 0) = kFocal_px * D;
    J.block<2, 3>(row, 3) = -kFocal_px * D * skew(T_C_M.R * point);
    row += 2;
  }
  return J;
}

/// Least squares on the corners from a start: Levenberg, since a frontal marker has a flat valley.
Pose solve_pose(const Corners& measured, Pose T) {
  double damping = 1e-3;
  double cost = (measured - project(T)).squaredNorm();
  for (int k = 0; k < 50; ++k) {
    const auto J = projection_jacobian(T);
    Matrix6 N = J.transpose() * J;
    N.diagonal() *= 1.0 + damping;
    const Vector6 d = N.ldlt().solve(J.transpose() * (measured - project(T)));
    const Pose next{so3_exp(d.tail<3>()) * T.R, T.p + d.head<3>()};
    const double next_cost = (measured - project(next)).squaredNorm();
    if (next_cost < cost) {
      T = next;
      cost = next_cost;
      damping *= 0.1;
    } else {
      damping *= 10.0;
    }
  }
  return T;
}

/// The other planar solution to start from: depth mirrored about the line of sight.
Pose mirrored(const Pose& T_C_M) {
  const Vector3 d = T_C_M.p.normalized();
  const Matrix3 mirror = Matrix3::Identity() - 2.0 * d * d.transpose();
  Pose T = T_C_M;
  T.R.col(0) = mirror * T_C_M.R.col(0);
  T.R.col(1) = mirror * T_C_M.R.col(1);
  T.R.col(2) = T.R.col(0).cross(T.R.col(1));
  return T;
}

bool is_visible(const Pose& T_C_M) {
  if (T_C_M.p.z() < 0.1) return false;
  const Corners corners = project(T_C_M);
  for (int i = 0; i < 4; ++i) {
    if (std::abs(corners[2 * i]) > 640 - 90 || std::abs(corners[2 * i + 1]) > 360 - 90) return false;
  }
  const double tilt = std::acos(-T_C_M.R.col(2).dot(T_C_M.p.normalized()));
  return tilt > 12 * kDegree && tilt < 58 * kDegree;
}

}  // namespace

TrueRobot true_robot(std::mt19937& random) {
  TrueRobot truth{default_arm(), default_T_C_B(), {}};
  truth.beta = random_between(JointVector::Constant(5, -8 * kDegree), JointVector::Constant(5, 8 * kDegree), random);
  return truth;
}

LearnedModel disturbed_model(const TrueRobot& truth, double position_sigma_m, double rotation_sigma_rad,
                             double beta_sigma_rad, double beta1_sigma_rad, std::mt19937& random) {
  std::normal_distribution<double> normal;
  StateVector x(11);
  x.head<3>() = random_vector(position_sigma_m, random);
  x.segment<3>(3) = random_vector(rotation_sigma_rad, random);
  for (int i = 0; i < 5; ++i) x[6 + i] = (i == 0 ? beta1_sigma_rad : beta_sigma_rad) * normal(random);
  return apply_error_state({1, truth.T_C_B, truth.beta}, x);
}

EkfOptions scaled_options(double scale) {
  EkfOptions options;
  options.prior_position_sigma_m = 0.03 * scale;
  options.prior_rotation_sigma_rad = 4.0 * kDegree * scale;
  options.prior_beta_sigma_rad = 3.0 * kDegree * scale;
  return options;
}

LearnedModel disturbed_by(const TrueRobot& truth, const EkfOptions& prior, std::mt19937& random) {
  return disturbed_model(truth, prior.prior_position_sigma_m, prior.prior_rotation_sigma_rad,
                         prior.prior_beta_sigma_rad, prior.prior_beta1_sigma_rad, random);
}

StateVector gauge_direction() {
  StateVector g = StateVector::Zero(11);
  g[kErrorW + 2] = 1.0;
  g[kErrorBeta] = -1.0;
  return g;
}

JointVector random_visible_posture(const TrueRobot& truth, std::mt19937& random) {
  while (true) {
    const JointVector q = random_within(truth.arm.limits, random);
    if (is_visible(truth.T_C_B * forward_kinematics(truth.arm.chain, q) * truth.arm.T_H_M)) return q;
  }
}

HandPoseMeasurement look_at(const TrueRobot& truth, const JointVector& q_real, const LookNoise& noise, bool flipped,
                            std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Pose T_C_M = truth.T_C_B * forward_kinematics(truth.arm.chain, q_real) * truth.arm.T_H_M;
  Corners corners = project(T_C_M);
  for (Eigen::Index i = 0; i < 8; ++i) corners[i] += noise.corner_sigma_px * normal(random);
  const Pose first = solve_pose(corners, T_C_M), second = solve_pose(corners, mirrored(T_C_M));
  const auto J = projection_jacobian(first);
  const Matrix6 normal_matrix = J.transpose() * J;
  const Matrix6 marker_covariance =
      noise.corner_sigma_px * noise.corner_sigma_px * normal_matrix.ldlt().solve(Matrix6::Identity());
  const Pose T_M_H = truth.arm.T_H_M.inverse();
  HandPoseMeasurement z;
  z.T_C_H = (flipped ? second : first) * T_M_H;
  z.T_C_H_second = (flipped ? first : second) * T_M_H;
  z.has_second = true;
  z.R_vision = hand_covariance(first, truth.arm.T_H_M, marker_covariance);
  z.q = q_real - truth.beta;
  for (Eigen::Index i = 0; i < z.q.size(); ++i) z.q[i] += noise.encoder_sigma_rad * normal(random);
  if (noise.floor_position_sigma_m > 0.0 || noise.floor_rotation_sigma_rad > 0.0) {
    const Vector3 shift = random_vector(noise.floor_position_sigma_m, random);
    const Matrix3 turn = so3_exp(random_vector(noise.floor_rotation_sigma_rad, random));
    z.T_C_H = {turn * z.T_C_H.R, z.T_C_H.p + shift};
    z.T_C_H_second = {turn * z.T_C_H_second.R, z.T_C_H_second.p + shift};
  }
  return z;
}

Vector6 hand_error(const TrueRobot& truth, const LearnedModel& model, const JointVector& q_real) {
  return pose_error(predict_T_C_H(truth.arm.chain, truth.T_C_B, truth.beta, q_real - truth.beta),
                    predict_T_C_H(truth.arm.chain, model.T_C_B, model.beta, q_real - truth.beta));
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

}  // namespace armsight::test
