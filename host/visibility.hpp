// Would the camera see the marker in that posture, and how well? Geometry alone: a pinhole (lens distortion stays
// inside the image margin), the marker's four corners, and the covariance of one look there (specification §5.4).
// Frames: C camera optical, B base, H hand, M marker (z out of the print). m, rad, px. Pure, no heap.
#pragma once

#include <optional>

#include "shared/hand_eye.hpp"

namespace armsight::host {

struct PinholeView {
  double width_px = 0, height_px = 0;
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
};

/// What makes a look worth taking. Frontal views have two solutions and no tilt information, far ones little of either.
struct ViewLimits {
  double image_margin_px = 90.0;
  double min_distance_m = 0.15, max_distance_m = 0.60;
  double min_tilt_rad = 0.2094, max_tilt_rad = 1.0123;  ///< 12° … 58° (specification §7.3)
};

/// Angle between the marker's normal and the line of sight, 0: frontal; above π/2 the print faces away.
double marker_tilt_rad(const Pose& T_C_M);

/// Does the marker at T_C_M satisfy the limits, all four corners inside the image less the margin?
bool is_well_visible(const PinholeView& view, const ViewLimits& limits, const Pose& T_C_M, double side_m);

struct LookNoise : NoiseModel {
  LookNoise() : NoiseModel{0.00175, 0.001, 0.00524} {}
  double corner_sigma_px = 0.25;
};

/// σ² (JᵀJ)⁻¹ of the four corners, rows position then rotation, in C; nullopt where a corner is behind the camera.
std::optional<Matrix6> marker_covariance(const PinholeView& view, const Pose& T_C_M, double side_m,
                                         double corner_sigma_px);

/// What a look tells about [v; w; ε_β]: Hᵀ R⁻¹ H with R = corners + encoders + floor. q is the real posture
/// (reading + beta). nullopt where the camera would see nothing.
std::optional<StateMatrix> look_information(const SerialChain& chain, const Pose& T_C_B, const Pose& T_H_M,
                                            const PinholeView& view, double side_m, const LookNoise& noise,
                                            const JointVector& q_real);

}  // namespace armsight::host
