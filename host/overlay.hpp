// What the host saw and thought, drawn on the picture: marker outlines, measured and predicted hand axes, a few lines.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/marker.hpp"
#include "shared/geometry.hpp"

namespace armsight::host {

struct Overlay {
  std::vector<MarkerDetection> markers;
  std::optional<Pose> measured_T_C_H;   ///< solid axes: x red, y green, z blue
  std::optional<Pose> predicted_T_C_H;  ///< pale axes
  std::optional<Pose> object_T_C_O;
  std::vector<std::string> lines;       ///< top left
};

/// A BGR copy of the picture with the overlay.
cv::Mat draw_overlay(const cv::Mat& image, const Intrinsics& intrinsics, const Overlay& overlay);

/// JPEG (quality 88) or PNG by the file's ending; makes missing folders. Throws std::runtime_error with the reason.
/// Part of armsight_host_camera, where picture files live.
void save_image(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace armsight::host
