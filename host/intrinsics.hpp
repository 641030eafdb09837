// The camera's inner geometry: pinhole and plumb_bob distortion, in pixels; integer coordinates are pixel centres.
// Files: ROS camera_info YAML and OpenCV FileStorage YAML, told apart by their keys, both read through
// protocol/strict_yaml.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core/types.hpp>

#include "shared/geometry.hpp"

namespace armsight::host {

struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::array<double, 5> plumb_bob{};  ///< k1 k2 p1 p2 k3
};

/// Throws ConfigError with every "file:line:column: key = value: rule"; keys of the formats that are not needed here
/// are passed over.
Intrinsics load_intrinsics(const std::filesystem::path& file);
/// The rule that `k` breaks, or nothing: sizes, positive focal lengths, centre in the picture, finite numbers.
std::string broken_rule(const Intrinsics& k);

/// Normalised image point (x/z, y/z) → distorted normalised point.
Eigen::Vector2d distort(const Intrinsics& k, const Eigen::Vector2d& xy);
/// Pixel → normalised, undistorted point; fixed-point iteration to 1e-12.
Eigen::Vector2d undistort(const Intrinsics& k, const cv::Point2d& pixel);
/// A point in C, z > 0, → pixel.
cv::Point2d project(const Intrinsics& k, const Vector3& p_C);
/// Normalised point → pixel.
cv::Point2d to_pixel(const Intrinsics& k, const Eigen::Vector2d& xy);

}  // namespace armsight::host
