#include "host/hand_looks.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace armsight::host {
namespace {

constexpr Duration kFrameTimeout = std::chrono::milliseconds(1500);  // for one frame: several periods of a slow camera
constexpr Duration kReadingSlack = std::chrono::milliseconds(20);    // one state of the arm either side

}  // namespace

cv::Mat overlaid(const LookTaken& taken, const Intrinsics& intrinsics, const std::vector<std::string>& lines) {
  if (taken.picture.empty()) return {};
  Overlay overlay;
  overlay.markers = taken.markers;
  if (taken.look) overlay.measured_T_C_H = taken.look->T_C_H;
  overlay.predicted_T_C_H = taken.predicted_T_C_X;
  overlay.lines = lines;
  if (!taken.why.empty()) overlay.lines.push_back(taken.why);
  return draw_overlay(taken.picture, intrinsics, overlay);
}

Looker::Looker(HostIo& io, const MarkerConfig& marker, const Pose& T_X_M)
    : io_(io), marker_(marker), T_X_M_(T_X_M), detector_(marker.dictionary) {}

bool Looker::sees(const cv::Mat& picture) const {
  const auto detections = detector_.detect(picture, io_.camera().intrinsics());
  return std::any_of(detections.begin(), detections.end(), [&](const MarkerDetection& d) {
    return d.id == marker_.id && d.edge_rms_px > 0.0;
  });
}

LookTaken Looker::look(int frames, const std::optional<Pose>& predicted_T_C_X) {
  LookTaken taken;
  taken.predicted_T_C_X = predicted_T_C_X;
  std::vector<LookFrame> found;
  io_.camera().request(frames);
  int came = 0, seen = 0;
  for (; came < frames; ++came) {
    if (!io_.wait_until([&] { return io_.frame().has_value(); }, kFrameTimeout)) break;
    const Frame frame = *io_.frame();
    taken.markers = detector_.detect(frame.gray_or_bgr, io_.camera().intrinsics());
    for (const MarkerDetection& d : taken.markers) {
      if (d.id != marker_.id) continue;
      ++seen;
      if (d.edge_rms_px > 0.0) found.push_back({d.corners_px, frame.capture_time});
    }
    taken.picture = frame.gray_or_bgr;
    io_.step();  // the frame has been used; the next may come
  }
  if (came == 0) {
    taken.why = "no picture came from " + io_.camera().name();
    return taken;
  }
  if (2 * static_cast<int>(found.size()) <= frames) {
    taken.why = seen == 0            ? kNotSeen
                : 2 * seen <= frames ? "marker seen in too few frames"
                                     : "marker seen, but its outline is covered";
    return taken;
  }
  LookResult result = make_look(found, marker_, T_X_M_, io_.camera().intrinsics(), predicted_T_C_X);
  if (!result.look) {
    taken.why = result.why;
    return taken;
  }
  const auto at = io_.arm().alignment().to_arm(result.look->capture_time);
  const auto from = io_.arm().alignment().to_arm(found.front().capture_time);
  const auto to = io_.arm().alignment().to_arm(found.back().capture_time);
  if (!at || !from || !to) {
    taken.why = "the clocks are out of step";
    return taken;
  }
  taken.arm_time = *at;
  const auto reading = io_.arm().mean_reading(from->arm_time - kReadingSlack, to->arm_time + kReadingSlack);
  if (reading)
    taken.q_reading = Eigen::Map<const Eigen::VectorXd>(reading->data(), static_cast<Eigen::Index>(reading->size()));
  else taken.why = "the arm told no joint angles of that time";
  taken.look = std::move(result.look);
  return taken;
}

}  // namespace armsight::host
