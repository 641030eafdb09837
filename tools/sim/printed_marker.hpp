// The printed marker in a simulated picture. Its four corners are first projected, then shifted by the corner noise;
// the homography through the shifted corners says which module a ray meets. So the noise sits in the pixels themselves.
#pragma once

#include <array>
#include <optional>

#include "host/marker.hpp"
#include "shared/geometry.hpp"

namespace armsight::sim {

using CornerShift = std::array<cv::Point2d, 4>;  ///< px, in the order of host::Corners

class MarkerPrint {
 public:
  /// nullopt: a corner is not before the camera.
  static std::optional<MarkerPrint> make(const host::MarkerPattern& pattern, double side_m, const Pose& T_C_M,
                                         const host::Intrinsics& intrinsics, const CornerShift& shift_px);

  /// The module met by the ray (x, y, 1): true = white; nullopt outside of the black border.
  std::optional<bool> is_white(double x, double y) const {
    const Vector3 m = modules_from_ray_ * Vector3(x, y, 1.0);
    const double column = m.x() / m.z(), row = m.y() / m.z();
    if (!(column >= 0.0 && row >= 0.0 && column < pattern_.modules && row < pattern_.modules)) return std::nullopt;
    return pattern_.at(static_cast<int>(row), static_cast<int>(column));
  }

 private:
  host::MarkerPattern pattern_;
  Matrix3 modules_from_ray_;  ///< ray → (column, row) in modules, from the top left corner
};

/// Projected corners in px; nullopt: one is not before the camera.
std::optional<host::Corners> project_corners(const Pose& T_C_M, double side_m, const host::Intrinsics& intrinsics);

}  // namespace armsight::sim
