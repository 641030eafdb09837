// One look at the hand: the marker's corners of some frames, taken while the arm is still, become one pose T_C_H with
// an honest covariance (F-V3 … F-V5). Pure: detections in, measurement out.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "host/planar_pose.hpp"
#include "protocol/config.hpp"
#include "shared/time.hpp"

namespace armsight::host {

struct LookFrame {
  Corners corners_px;
  Time capture_time;
};

struct LookOptions {
  double corner_sigma_px = 0.25;   ///< noise of a corner in one frame, until the frames themselves tell
  double corner_floor_px = 0.15;   ///< what frames of one look share: print, lens, light. Averaging does not remove it
  double clear_delta_chi2 = 12.0;  ///< above, the better planar solution is taken alone
  double outlier_px = 1.5;         ///< a frame with a corner so far from the median of all is dropped ...
  double still_px = 0.75;          ///< ... and if the rest scatters more than this (rms), the marker moved
};

struct LookMeasurement {
  Pose T_C_H;
  std::optional<Pose> second_T_C_H;  ///< the other planar solution, where nothing decided against it
  Matrix6 covariance;                ///< of T_C_H, rows position then rotation, in C
  Corners corners_px;                ///< mean of the frames used
  double reprojection_px = 0.0;
  double scatter_px = 0.0;           ///< of a corner coordinate between frames; 0 for one frame
  double delta_chi2 = 0.0;           ///< how clearly the better solution wins; 0: there is only one
  bool was_decided_by_prediction = false;
  Time capture_time;                 ///< mean of the frames used
  int frames = 0;
  int id = 0;
};

struct LookResult {
  std::optional<LookMeasurement> look;
  std::string why;  ///< no look: the reason
};

/// `predicted_T_C_H` decides between the two solutions where the picture does not; T_H_M is the mount.
LookResult make_look(std::span<const LookFrame> frames, const MarkerConfig& marker, const Pose& T_H_M,
                     const Intrinsics& intrinsics, const std::optional<Pose>& predicted_T_C_H,
                     const LookOptions& options = {});

}  // namespace armsight::host
