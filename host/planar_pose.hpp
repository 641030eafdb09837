// From four corners of a square to its pose in C: both solutions of the planar problem, each polished, with covariance.
// M is the marker (x right, y up, z out of the print, origin at its centre). m, rad, px. Pure.
#pragma once

#include <optional>

#include "host/marker.hpp"
#include "shared/geometry.hpp"

namespace armsight::host {

struct PlanarPose {
  Pose T_C_M;
  Matrix6 covariance;   ///< rows position then rotation, in C, R ← exp(φ) R; for the sigma_px handed in
  double rms_px = 0.0;  ///< reprojection, a coordinate
};

struct PlanarSolutions {
  PlanarPose best;                    ///< smaller reprojection error
  std::optional<PlanarPose> second;   ///< only if it stands more than 1° away
  double error_ratio = 0.0;           ///< rms of second over rms of best; 0 without a second
  double delta_chi2 = 0.0;            ///< (SSE₂ − SSE₁)/σ²: above 12 the best alone is right (≤ 0.2 % wrong)
};

/// nullopt: no solution in front of the camera. sigma_px: noise of one corner coordinate.
std::optional<PlanarSolutions> solve_planar_pose(const Corners& corners_px, double side_m, const Intrinsics& intrinsics,
                                                 double sigma_px);

/// Levenberg-Marquardt on the four corners from a start; nullopt where it leaves the front of the camera.
std::optional<PlanarPose> refine_planar_pose(const Pose& start_T_C_M, const Corners& corners_px, double side_m,
                                             const Intrinsics& intrinsics, double sigma_px);

/// The four corners in M.
std::array<Vector3, 4> marker_corners_M(double side_m);

}  // namespace armsight::host
