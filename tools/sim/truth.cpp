#include "tools/sim/truth.hpp"

namespace armsight::sim {

namespace {

Pose turn_and_shift(Random& random, double turn_rad, double shift_m) {
  const Vector3 axis = random.direction();
  return {so3_exp(turn_rad * axis), shift_m * random.direction()};
}

/// O stands upright, z_O against gravity, at any yaw, shifted on the table.
Pose stand_object(const SceneObject& object, const Vector3& gravity, std::uint64_t seed) {
  Random random(seed, kForObject);
  const Vector3 up = -gravity.normalized();
  const Vector3 level = up.unitOrthogonal();
  Pose T_B_O;
  T_B_O.R.col(0) = level;
  T_B_O.R.col(1) = up.cross(level);
  T_B_O.R.col(2) = up;
  const double x = random.uniform(-object.spread_m, object.spread_m);
  const double y = random.uniform(-object.spread_m, object.spread_m);
  T_B_O.p = object.position_B + x * T_B_O.R.col(0) + y * T_B_O.R.col(1);
  T_B_O.R = T_B_O.R * so3_exp({0, 0, random.uniform(-std::numbers::pi, std::numbers::pi)});
  return T_B_O;
}

/// The fixed poses between the joints, each a little longer, shorter or beside itself.
SerialChain wrong_links(const SerialChain& nominal, double sigma_m, std::uint64_t seed) {
  SerialChain chain = nominal;
  for (int i = 0; i < chain.joint_count; ++i) {
    Random random(seed, kForLinks, static_cast<std::uint64_t>(i));
    const Vector3 error(random.normal(), random.normal(), random.normal());
    chain.T_after[static_cast<std::size_t>(i)].p += sigma_m * error;
  }
  return chain;
}

/// Bent, well inside the limits, palm not necessarily in view.
JointVector start_posture(const JointLimits& limits, std::uint64_t seed) {
  JointVector q(limits.min_rad.size());
  for (int i = 0; i < q.size(); ++i) {
    Random random(seed, kForStart, static_cast<std::uint64_t>(i));
    const double part = random.uniform(0.35, 0.65);
    q[i] = limits.min_rad[i] + part * (limits.max_rad[i] - limits.min_rad[i]);
  }
  return q;
}

}  // namespace

Truth make_truth(const RobotConfig& robot, const Scene& scene, NoiseSet noise, CameraMount mount, std::uint64_t seed) {
  const NoiseFigures figures = noise_figures(noise);
  Truth truth;
  truth.seed = seed;
  truth.noise = noise;
  truth.chain = wrong_links(robot.arm.chain, figures.link_m, seed);
  Random mount_error(seed, kForMarkerMount);
  truth.T_H_M = robot.arm.T_H_M * turn_and_shift(mount_error, figures.marker_mount_rad, figures.marker_mount_m);
  truth.T_B_O = stand_object(scene.object, robot.gravity_m_s2, seed);
  truth.T_C_B = mount == CameraMount::kNear ? near_mount(robot.camera_hint_T_C_B, figures, seed)
                                            : mount_anywhere(robot, scene, truth.T_B_O, seed);
  const int n = robot.arm.joint_count();
  truth.beta = JointVector::Zero(n);
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    truth.beta[i] = Random(seed, kForBeta, k).uniform(-figures.beta_max_rad, figures.beta_max_rad);
    truth.encoder_error[k] = SmoothError(figures.encoder_rad, Random(seed, kForEncoder, k));
    truth.servo_residual[k] = SmoothError(figures.servo_residual_rad, Random(seed, kForServo, k));
  }
  truth.start_rad = start_posture(robot.arm.limits, seed) + truth.beta;
  return truth;
}

void inject_drift(Truth& truth) {
  const NoiseFigures figures = noise_figures(truth.noise);
  Random camera(truth.seed, kForDrift);
  truth.T_C_B = turn_and_shift(camera, figures.drift_camera_rad, figures.drift_camera_m) * truth.T_C_B;
  for (int i = 0; i < truth.beta.size(); ++i) {
    Random joint(truth.seed, kForDrift, static_cast<std::uint64_t>(i) + 1);
    truth.beta[i] += joint.uniform(-figures.drift_beta_max_rad, figures.drift_beta_max_rad);
  }
}

Pose near_mount(const Pose& nominal_T_C_B, const NoiseFigures& figures, std::uint64_t seed) {
  Random random(seed, kForCamera);
  const double turn = random.uniform(0.0, figures.camera_max_rad);
  const double shift = random.uniform(0.0, figures.camera_max_m);
  return turn_and_shift(random, turn, shift) * nominal_T_C_B;
}

}  // namespace armsight::sim
