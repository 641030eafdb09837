// Marker corners from the marker's outline: gray profiles across its four edges, one straight line an edge, corners
// where lines meet. Lines are fitted after undistortion, for a lens bends them. Pure; about 0.2 ms a marker.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "host/marker.hpp"

namespace armsight::host {

struct RefinedCorners {
  Corners corners_px;
  double edge_rms_px = 0.0;
};

/// From corners good to ±2 px, or of the contour that a threshold leaves inside a wide border. nullopt where an edge
/// cannot be seen on a third of its length, or a corner would move by more than 3 px: then the outline is not what it
/// should be. `modules`: of the marker with its border.
std::optional<RefinedCorners> refine_corners(const cv::Mat& gray, const Intrinsics& intrinsics,
                                             const Corners& corners_px, int modules);

}  // namespace armsight::host
