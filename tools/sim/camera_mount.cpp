// A camera somewhere else: turned about the workspace, farther away, and kept only if from there palm and object can be
// seen as a person would place it.
#include <stdexcept>

#include "tools/sim/truth.hpp"

namespace armsight::sim {

namespace {

constexpr double kMargin_px = 60.0;
constexpr double kMaxTilt_rad = 60 * kDegree;
constexpr int kPostures = 600;
constexpr double kVisiblePart = 0.03;  // 5 % at the nominal mount (specification §4.6)
constexpr int kTries = 400;

/// Is the plane spot at T_C_X in the picture, seen from its front (+z_X) at no grazing angle?
bool is_visible(const Pose& T_C_X, const host::Intrinsics& k) {
  const Vector3& p = T_C_X.p;
  if (p.z() < 0.12) return false;
  const double u = k.fx * p.x() / p.z() + k.cx, v = k.fy * p.y() / p.z() + k.cy;
  if (u < kMargin_px || u > k.width - kMargin_px || v < kMargin_px || v > k.height - kMargin_px) return false;
  const double cosine = -p.normalized().dot(T_C_X.R.col(2));
  return cosine > std::cos(kMaxTilt_rad);
}

double visible_part(const RobotConfig& robot, const host::Intrinsics& k, const Pose& T_C_B, std::uint64_t seed) {
  const JointLimits& limits = robot.arm.limits;
  int visible = 0;
  for (int posture = 0; posture < kPostures; ++posture) {
    Random random(seed, kForCamera, static_cast<std::uint64_t>(posture) + 1000);
    JointVector q(limits.min_rad.size());
    for (int i = 0; i < q.size(); ++i) q[i] = random.uniform(limits.min_rad[i], limits.max_rad[i]);
    visible += is_visible(T_C_B * forward_kinematics(robot.arm.chain, q) * robot.arm.T_H_M, k) ? 1 : 0;
  }
  return static_cast<double>(visible) / kPostures;
}

/// The nominal camera carried about a point of its axis by a turn, drawn back, and rolled.
Pose carried(const Pose& nominal_T_C_B, Random& random) {
  constexpr double kWorkDistance_m = 0.30;
  const Pose T_B_C = nominal_T_C_B.inverse();
  const Vector3 centre = T_B_C * Vector3(0, 0, kWorkDistance_m);
  const Matrix3 R = so3_exp(random.uniform(15 * kDegree, 50 * kDegree) * random.direction());
  const Matrix3 roll = so3_exp({0, 0, random.uniform(-40 * kDegree, 40 * kDegree)});
  Pose moved;
  moved.R = R * T_B_C.R * roll;
  moved.p = centre - random.uniform(1.0, 1.5) * kWorkDistance_m * moved.R.col(2);
  return moved.inverse();
}

}  // namespace

Pose mount_anywhere(const RobotConfig& robot, const Scene& scene, const Pose& T_B_O, std::uint64_t seed) {
  const host::Intrinsics& k = scene.camera.intrinsics;
  const Pose T_O_M{Matrix3::Identity(), {0, 0, scene.object.marker_height_m}};
  for (std::uint64_t i = 0; i < kTries; ++i) {
    Random random(seed, kForCamera, i);
    const Pose T_C_B = carried(robot.camera_hint_T_C_B, random);
    if (is_visible(T_C_B * T_B_O * T_O_M, k) && visible_part(robot, k, T_C_B, seed) >= kVisiblePart) return T_C_B;
  }
  throw std::runtime_error("no place for the camera found from which palm and object are visible; take another seed");
}

}  // namespace armsight::sim
