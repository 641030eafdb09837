#include "shared/kinematics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace armsight {
namespace {

/// T · Rz(angle): a turn about z only mixes the first two columns.
void turn_about_z(Pose& T, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const Vector3 x = T.R.col(0);
  T.R.col(0) = c * x + s * T.R.col(1);
  T.R.col(1) = c * T.R.col(1) - s * x;
}

/// T · A, written out by columns: what the compiler makes of it is a third faster than of the product of matrices.
void move_along(Pose& T, const Pose& A) {
  const Vector3 x = T.R.col(0), y = T.R.col(1), z = T.R.col(2);
  T.p += A.p[0] * x + A.p[1] * y + A.p[2] * z;
  for (Eigen::Index j = 0; j < 3; ++j) T.R.col(j) = A.R(0, j) * x + A.R(1, j) * y + A.R(2, j) * z;
}

/// Sum of the link lengths as seen from joint 1.
double links_length_m(const SerialChain& chain) {
  double length = 0.0;
  for (int i = 0; i < chain.joint_count; ++i) {
    const double squared = chain.T_after[static_cast<std::size_t>(i)].p.squaredNorm();
    if (squared > 0.0) length += std::sqrt(squared);
  }
  return length;
}

/// Smallest root of λ³ − e1 λ² + e2 λ − e3, the characteristic polynomial of a positive semidefinite matrix: Newton's
/// iteration from 0 rises to it from below, and takes no trigonometry. Ends early at `enough`.
double smallest_root(double e1, double e2, double e3, double enough) {
  double lambda = 0.0;
  for (int k = 0; k < 60 && lambda < enough; ++k) {  // two equal eigenvalues halve the error a step, others square it
    const double value = ((e1 - lambda) * lambda - e2) * lambda + e3;
    const double slope = (2.0 * e1 - 3.0 * lambda) * lambda - e2;
    if (!(value > 0.0) || !(slope < 0.0)) break;
    const double step = -value / slope;
    lambda += step;
    if (step <= 1e-9 * lambda) break;
  }
  return lambda;
}

}  // namespace

Pose forward_kinematics(const SerialChain& chain, const JointVector& q) {
  assert(q.size() == chain.joint_count);
  Pose T = chain.T_B_0;
  for (int i = 0; i < chain.joint_count; ++i) {
    turn_about_z(T, q[i]);
    move_along(T, chain.T_after[static_cast<std::size_t>(i)]);
  }
  return T;
}

HandKinematics hand_kinematics(const SerialChain& chain, const JointVector& q) {
  assert(q.size() == chain.joint_count);
  HandKinematics hand;
  hand.J.resize(6, chain.joint_count);
  std::array<Vector3, kMaxJoints> origin;
  Pose T = chain.T_B_0;
  for (int i = 0; i < chain.joint_count; ++i) {
    origin[static_cast<std::size_t>(i)] = T.p;
    hand.J.col(i).tail<3>() = T.R.col(2);  // a turn about z leaves z alone
    turn_about_z(T, q[i]);
    move_along(T, chain.T_after[static_cast<std::size_t>(i)]);
  }
  for (int i = 0; i < chain.joint_count; ++i) {
    const Vector3 z = hand.J.col(i).tail<3>();
    hand.J.col(i).head<3>() = z.cross(T.p - origin[static_cast<std::size_t>(i)]);  // §4.2
  }
  hand.T_B_H = T;
  return hand;
}

double position_manipulability(const SerialChain& chain, const JointVector& q) {
  if (chain.joint_count < 3) return 0.0;  // too few joints: no posture moves in all directions
  return position_manipulability(chain, hand_kinematics(chain, q).J);
}

double position_manipulability(const SerialChain& chain, const Jacobian& J, double enough) {
  const double length = links_length_m(chain);
  if (length <= 0.0 || chain.joint_count < 3) return 0.0;
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;  // of J_P J_Pᵀ
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    const double x = J(0, i), y = J(1, i), z = J(2, i);
    xx += x * x, yy += y * y, zz += z * z;
    xy += x * y, xz += x * z, yz += y * z;
  }
  const double least = enough * enough * length * length;
  const double x = xx - least, y = yy - least, z = zz - least;
  // Positive definite still, by its leading minors: all eigenvalues lie above. Spares nearly all postures the iteration.
  if (x > 0.0 && x * y > xy * xy && x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz) > 0.0)
    return enough;
  const double e1 = xx + yy + zz;
  const double e2 = (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz);
  const double e3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  return std::sqrt(smallest_root(e1, e2, e3, least)) / length;
}

double reach_m(const SerialChain& chain) { return chain.T_B_0.p.norm() + links_length_m(chain); }

}  // namespace armsight
