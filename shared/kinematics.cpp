#include "shared/kinematics.hpp"

#include <Eigen/Eigenvalues>
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

/// Sum of the link lengths as seen from joint 1.
double links_length_m(const SerialChain& chain) {
  double length = 0.0;
  for (int i = 0; i < chain.joint_count; ++i) length += chain.T_after[static_cast<std::size_t>(i)].p.norm();
  return length;
}

}  // namespace

Pose forward_kinematics(const SerialChain& chain, const JointVector& q) {
  assert(q.size() == chain.joint_count);
  Pose T = chain.T_B_0;
  for (int i = 0; i < chain.joint_count; ++i) {
    turn_about_z(T, q[i]);
    T = T * chain.T_after[static_cast<std::size_t>(i)];
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
    T = T * chain.T_after[static_cast<std::size_t>(i)];
  }
  for (int i = 0; i < chain.joint_count; ++i) {
    const Vector3 z = hand.J.col(i).tail<3>();
    hand.J.col(i).head<3>() = z.cross(T.p - origin[static_cast<std::size_t>(i)]);  // §4.2
  }
  hand.T_B_H = T;
  return hand;
}

double position_manipulability(const SerialChain& chain, const JointVector& q) {
  const double length = links_length_m(chain);
  if (length <= 0.0 || chain.joint_count < 3) return 0.0;  // too few joints: no posture moves in all directions
  const Jacobian J = hand_kinematics(chain, q).J;
  const Matrix3 JJt = J.topRows<3>() * J.topRows<3>().transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(JJt, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0])) / length;
}

double reach_m(const SerialChain& chain) { return chain.T_B_0.p.norm() + links_length_m(chain); }

}  // namespace armsight
