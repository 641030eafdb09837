// A stage for pictures: the default robot's scene with the hand marker put where a test wants it.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "protocol/config.hpp"
#include "tools/sim/renderer.hpp"

namespace armsight::test {

inline RobotConfig default_robot() {
  return load_robot(ARMSIGHT_SOURCE_DIR "/arm_controller/config/ego_right_arm.yaml");
}
inline sim::Scene default_scene() { return sim::load_scene(ARMSIGHT_SOURCE_DIR "/tools/sim/scene.yaml"); }
inline sim::NoiseFigures no_noise() { return {}; }

/// The same scene under a sensor without noise.
inline sim::Scene quiet_scene() {
  sim::Scene scene = default_scene();
  scene.camera.read_noise_levels = 0.0;
  scene.camera.shot_noise_levels = 0.0;
  return scene;
}

/// The object stands upright at its place.
inline Pose upright_object(const RobotConfig& robot, const Vector3& p_B) {
  const Vector3 up = -robot.gravity_m_s2.normalized();
  const Vector3 x = (Vector3::UnitZ() - up * up.z()).normalized();
  Pose T_B_O;
  T_B_O.R << x, up.cross(x), up;
  T_B_O.p = p_B;
  return T_B_O;
}

/// The hand marker at T_C_M. The object is out of sight, behind the camera.
inline sim::WorldView world_with_marker(const RobotConfig& robot, const Pose& T_C_M) {
  sim::WorldView world;
  world.T_C_B = robot.camera_hint_T_C_B;
  world.T_H_M = robot.arm.T_H_M;
  world.T_B_H = world.T_C_B.inverse() * T_C_M * world.T_H_M.inverse();
  world.T_B_O = upright_object(robot, world.T_C_B.inverse() * Vector3(0.0, 0.0, -1.0));
  return world;
}

/// Distance along the ray through (x, y, 1), tilt against that ray towards `azimuth`, roll about the print's normal.
inline Pose marker_pose(double x, double y, double distance_m, double tilt_rad, double azimuth_rad, double roll_rad) {
  const Vector3 ray = Vector3(x, y, 1.0).normalized();
  const Matrix3 facing = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), -ray).toRotationMatrix();
  const Vector3 axis(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0);
  return {facing * so3_exp(tilt_rad * axis) * so3_exp(Vector3(0, 0, roll_rad)), distance_m * ray};
}

/// As Learn plans its looks (specification §7.3): 12–58° of tilt, the marker well inside the picture. The print's y
/// axis points at the wrist; it stays in the upper half so that the forearm does not come between.
inline Pose random_marker_pose(std::mt19937_64& random, double min_distance_m = 0.18, double max_distance_m = 0.40) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double distance = min_distance_m + (max_distance_m - min_distance_m) * unit(random);
  const double tilt = (12.0 + 46.0 * unit(random)) * kDegree;
  const double x = -0.55 + 1.1 * unit(random), y = -0.26 + 0.52 * unit(random);
  return marker_pose(x, y, distance, tilt, 2.0 * std::numbers::pi * unit(random),
                     2.0 * std::numbers::pi * unit(random));
}

}  // namespace armsight::test
