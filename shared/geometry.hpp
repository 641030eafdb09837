// Rotations and poses. T_A_B maps B coordinates to A: p_A = T_A_B * p_B, and T_A_C = T_A_B * T_B_C reads through.
// Metres, radians. Rotation vectors: direction = axis, length = angle. Quaternions are (w, x, y, z) in names.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace armsight {

using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// For text that people read: angle_rad / kDegree is in degrees.
inline constexpr double kDegree = 3.14159265358979323846 / 180.0;

/// A pose: rotation and translation of one frame in another.
struct Pose {
  Matrix3 R = Matrix3::Identity();
  Vector3 p = Vector3::Zero();

  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

inline Pose operator*(const Pose& a, const Pose& b) { return {a.R * b.R, a.R * b.p + a.p}; }
inline Vector3 operator*(const Pose& a, const Vector3& p) { return a.R * p + a.p; }

/// S(v), the cross product as a matrix: skew(v) * x = v × x.
Matrix3 skew(const Vector3& v);
/// The vector of the skew part of M: vee(skew(v)) = v; specification §2.
Vector3 vee(const Matrix3& M);

/// Rotation by the rotation vector phi (Rodrigues), exact down to |phi| = 0.
Matrix3 so3_exp(const Vector3& phi);
/// Rotation vector of R, |phi| ≤ π, sound near 0 and near π.
Vector3 so3_log(const Matrix3& R);
/// Left Jacobian of SO(3): exp(phi + d) ≈ exp(J_l(phi) d) exp(phi).
Matrix3 so3_left_jacobian(const Vector3& phi);

/// Position and orientation error of `measured` against `estimated`, both in the same frame, rows 0–2 and 3–5:
/// e_P = p_meas − p_est (5.17) and e_O = log(R_meas R_estᵀ), the angle form of (5.18) (specification §5.1).
Vector6 pose_error(const Pose& measured, const Pose& estimated);
/// (5.18) as the thesis prints it: ½ (R̃ − R̃ᵀ)^∨ = sin θ · u. For comparison with the thesis only.
Vector3 orientation_error_sine(const Matrix3& R_measured, const Matrix3& R_estimated);

/// Angle between two rotations, in [0, π].
double rotation_angle(const Matrix3& R_a, const Matrix3& R_b);

/// Nearest rotation to M in the Frobenius sense (SVD); M must have a positive determinant.
Matrix3 nearest_rotation(const Matrix3& M);
bool is_finite(const Pose& T);
/// RᵀR = I and det R = +1 to the tolerance.
bool is_rotation(const Matrix3& R, double tolerance = 1e-6);

}  // namespace armsight
