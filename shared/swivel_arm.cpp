#include "shared/swivel_arm.hpp"

#include <cmath>

namespace armsight {
namespace {

constexpr double kGeometry = 1e-9;  // m and rad: what still counts as the arm's own geometry

bool is_zero(double length_or_sine) { return std::abs(length_or_sine) < kGeometry; }

/// Distance of a point from a line through `origin`.
double distance_to_line(const Vector3& point, const Vector3& origin, const Vector3& axis) {
  return axis.cross(point - origin).norm();
}

/// Where the lines meet; nullopt where they are parallel.
std::optional<Vector3> meeting_point(const Vector3& o1, const Vector3& z1, const Vector3& o2, const Vector3& z2) {
  const Vector3 n = z1.cross(z2);
  if (is_zero(n.norm())) return std::nullopt;
  return Vector3(o1 + z1 * ((o2 - o1).cross(z2).dot(n) / n.squaredNorm()));
}

}  // namespace

std::optional<SwivelArm> swivel_arm(const SerialChain& chain) {
  if (chain.joint_count != 5) return std::nullopt;
  SwivelArm arm;
  std::array<Vector3, 5> origin;
  Pose T = chain.T_B_0;
  for (std::size_t i = 0; i < 5; ++i) {
    arm.axis[i] = T.R.col(2);
    origin[i] = T.p;
    T = T * chain.T_after[i];
  }
  const auto& z = arm.axis;
  for (std::size_t i = 0; i + 1 < 5; ++i)
    if (!is_zero(z[i].dot(z[i + 1]))) return std::nullopt;
  const Vector3 shoulder = *meeting_point(origin[0], z[0], origin[1], z[1]);
  const Vector3 elbow = *meeting_point(origin[2], z[2], origin[3], z[3]);
  for (std::size_t i = 0; i < 3; ++i)
    if (!is_zero(distance_to_line(shoulder, origin[i], z[i]))) return std::nullopt;
  for (std::size_t i = 2; i < 5; ++i)
    if (!is_zero(distance_to_line(elbow, origin[i], z[i]))) return std::nullopt;
  if (!is_zero(distance_to_line(T.p, origin[4], z[4]))) return std::nullopt;
  arm.upper_arm_m = (elbow - shoulder).norm();
  arm.forearm_m = (T.p - elbow).norm();
  if (is_zero(arm.upper_arm_m) || is_zero(arm.forearm_m)) return std::nullopt;
  arm.shoulder = shoulder;
  arm.upper_arm = (elbow - shoulder) / arm.upper_arm_m;
  arm.forearm = (T.p - elbow) / arm.forearm_m;
  arm.elbow_at_zero_rad = std::atan2(z[3].dot(arm.upper_arm.cross(arm.forearm)), arm.upper_arm.dot(arm.forearm));
  arm.R_B_H = T.R;
  return arm;
}

}  // namespace armsight
