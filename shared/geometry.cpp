#include "shared/geometry.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace armsight {

Matrix3 skew(const Vector3& v) {
  Matrix3 S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Vector3 vee(const Matrix3& M) {
  return 0.5 * Vector3(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
}

Matrix3 so3_exp(const Vector3& phi) {
  const double angle = phi.norm();
  const Matrix3 S = skew(phi);
  if (angle < 1e-5) return Matrix3::Identity() + S + 0.5 * S * S;  // next term: 1e-16
  const double half_sine = std::sin(0.5 * angle);
  return Matrix3::Identity() + std::sin(angle) / angle * S + 2.0 * half_sine * half_sine / (angle * angle) * S * S;
}

Vector3 so3_log(const Matrix3& R) {
  // By the quaternion, which Eigen takes from the largest of trace and diagonal: sound near 0 and near π.
  Eigen::Quaterniond quat(R);
  if (quat.w() < 0.0) quat.coeffs() = -quat.coeffs();
  const double half_sine = quat.vec().norm();
  if (half_sine < 1e-8) return 2.0 * quat.vec() / quat.w();
  return 2.0 * std::atan2(half_sine, quat.w()) / half_sine * quat.vec();
}

Matrix3 so3_left_jacobian(const Vector3& phi) {
  const double angle = phi.norm();
  const Matrix3 S = skew(phi);
  if (angle < 1e-4) return Matrix3::Identity() + 0.5 * S + S * S / 6.0;
  const double half_sine = std::sin(0.5 * angle);
  return Matrix3::Identity() + 2.0 * half_sine * half_sine / (angle * angle) * S +
         (angle - std::sin(angle)) / (angle * angle * angle) * S * S;
}

Vector6 pose_error(const Pose& measured, const Pose& estimated) {
  Vector6 e;
  e << measured.p - estimated.p, so3_log(measured.R * estimated.R.transpose());
  return e;
}

Vector3 orientation_error_sine(const Matrix3& R_measured, const Matrix3& R_estimated) {
  return vee(R_measured * R_estimated.transpose());
}

double rotation_angle(const Matrix3& R_a, const Matrix3& R_b) { return so3_log(R_a * R_b.transpose()).norm(); }

Matrix3 nearest_rotation(const Matrix3& M) {
  const Eigen::JacobiSVD<Matrix3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3 d(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0);
  return svd.matrixU() * d.asDiagonal() * svd.matrixV().transpose();
}

bool is_finite(const Pose& T) { return T.R.allFinite() && T.p.allFinite(); }

bool is_rotation(const Matrix3& R, double tolerance) {
  return R.allFinite() && (R.transpose() * R - Matrix3::Identity()).cwiseAbs().maxCoeff() <= tolerance &&
         R.determinant() > 0.0;
}

}  // namespace armsight
