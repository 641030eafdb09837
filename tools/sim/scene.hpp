// The simulated scene (tools/sim/scene.yaml): the camera with its errors, light, table, object, and when a grasp holds.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "host/intrinsics.hpp"
#include "protocol/config.hpp"
#include "shared/geometry.hpp"

namespace armsight::sim {

struct CameraOptics {
  host::Intrinsics intrinsics;  ///< nominal and true: no noise set of specification §7.1 parts them
  double rate_hz = 0.0;
  double exposure_s = 0.0;
  double latency_s = 0.0;
  double latency_spread_s = 0.0;
  double defocus_px = 0.0;
  double read_noise_levels = 0.0;
  double shot_noise_levels = 0.0;
};

struct Light {
  double exposure_gain = 1.0;
  std::array<double, 3> lamp_up_forward_right{};
  double vignetting = 0.0;
  double gradient = 0.0;
};

struct Table {
  double half_right_m = 0.0, half_forward_m = 0.0;
  double thickness_m = 0.0;
  double shift_right_m = 0.0, shift_forward_m = 0.0;
};

struct SceneObject {
  std::string name;
  double radius_m = 0.0;
  double height_m = 0.0;
  Vector3 position_B = Vector3::Zero();  ///< of O, before the seeded shift
  double spread_m = 0.0;
  MarkerConfig marker;
  double marker_height_m = 0.0;          ///< T_O_M = (identity, (0, 0, marker_height))
};

struct GraspTruth {
  Vector3 centre_H = Vector3::Zero();    ///< of the object in the hand
  double tolerance_m = 0.0;
  double tolerance_rad = 0.0;
};

struct Scene {
  CameraOptics camera;
  Light light;
  double hand_plate_side_m = 0.0;
  Table table;
  SceneObject object;
  GraspTruth grasp;
};

/// Throws ConfigError with every violation.
Scene load_scene(const std::filesystem::path& file);

}  // namespace armsight::sim
