#include "shared/gravity.hpp"

#include <cmath>

namespace armsight {
namespace {

Pose turned_about_z(double angle_rad) {
  Pose T;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  T.R << c, -s, 0, s, c, 0, 0, 0, 1;
  return T;
}

}  // namespace

JointVector gravity_torque(const SerialChain& chain, const LinkMasses& links, const Vector3& gravity_m_s2,
                           const JointVector& q) {
  std::array<Vector3, kMaxJoints> axis, origin, moment;
  Pose T = chain.T_B_0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joint_count); ++i) {
    axis[i] = T.R.col(2);
    origin[i] = T.p;
    T = T * turned_about_z(q[static_cast<Eigen::Index>(i)]) * chain.T_after[i];
    moment[i] = links[i].mass_kg * (T * links[i].com_m);
  }
  JointVector torque(chain.joint_count);
  double mass = 0.0;                         // of all links from here to the hand
  Vector3 first_moment = Vector3::Zero();    // and Σ m p
  for (int j = chain.joint_count - 1; j >= 0; --j) {
    const auto i = static_cast<std::size_t>(j);
    mass += links[i].mass_kg;
    first_moment += moment[i];
    torque[j] = -gravity_m_s2.dot(axis[i].cross(first_moment - mass * origin[i]));
  }
  return torque;
}

double potential_energy(const SerialChain& chain, const LinkMasses& links, const Vector3& gravity_m_s2,
                        const JointVector& q) {
  Pose T = chain.T_B_0;
  double energy = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joint_count); ++i) {
    T = T * turned_about_z(q[static_cast<Eigen::Index>(i)]) * chain.T_after[i];
    energy -= links[i].mass_kg * gravity_m_s2.dot(T * links[i].com_m);
  }
  return energy;
}

}  // namespace armsight
