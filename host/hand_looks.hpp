// Look at a marker: ask for frames while the arm stands, find the marker in each, make one measurement of them.
// Host clock in, arm clock out (ArmLink's alignment). m, rad, px.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "host/host_io.hpp"
#include "host/look.hpp"
#include "host/marker.hpp"
#include "host/overlay.hpp"

namespace armsight::host {

inline constexpr const char* kNotSeen = "marker not seen";

struct LookTaken {
  std::optional<LookMeasurement> look;
  std::string why;            ///< no look, or no reading: the reason
  cv::Mat picture;            ///< the last frame, for the overlay; empty when none came
  std::vector<MarkerDetection> markers;  ///< of this frame
  std::optional<Pose> predicted_T_C_X;   ///< as handed in
  AlignedTime arm_time{};     ///< of the look's capture time
  JointVector q_reading;      ///< mean over the frames; zero size where the arm told nothing then
};

/// The last frame with markers, axes and words drawn in; empty when none came.
cv::Mat overlaid(const LookTaken& taken, const Intrinsics& intrinsics, const std::vector<std::string>& lines);

class Looker {
 public:
  /// Looks at `marker`, which sits at T_X_M on its carrier X: T_C_X is measured (`T_C_H` of LookMeasurement).
  Looker(HostIo& io, const MarkerConfig& marker, const Pose& T_X_M);

  /// n frames of the standing arm. `predicted_T_C_X` decides between the planar solutions.
  LookTaken look(int frames, const std::optional<Pose>& predicted_T_C_X);
  /// Is the marker in this picture, with an outline good enough to measure?
  bool sees(const cv::Mat& picture) const;

 private:
  HostIo& io_;
  MarkerConfig marker_;
  Pose T_X_M_;
  MarkerDetector detector_;
};

}  // namespace armsight::host
