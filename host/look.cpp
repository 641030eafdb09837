#include "host/look.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/hand_eye.hpp"

namespace armsight::host {
namespace {

/// A prediction decides if the other solution is farther from it by this much more.
constexpr double kDecisive_rad = 10.0 * kDegree;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Corners median_corners(std::span<const LookFrame> frames) {
  Corners result;
  for (std::size_t c = 0; c < 4; ++c) {
    std::vector<double> x, y;
    for (const LookFrame& frame : frames) {
      x.push_back(frame.corners_px[c].x);
      y.push_back(frame.corners_px[c].y);
    }
    result[c] = {median(x), median(y)};
  }
  return result;
}

std::vector<LookFrame> without_outliers(std::span<const LookFrame> frames, double outlier_px) {
  const Corners middle = median_corners(frames);
  std::vector<LookFrame> kept;
  for (const LookFrame& frame : frames) {
    double worst = 0.0;
    for (std::size_t c = 0; c < 4; ++c) {
      const cv::Point2d off = frame.corners_px[c] - middle[c];
      worst = std::max(worst, std::hypot(off.x, off.y));
    }
    if (worst <= outlier_px) kept.push_back(frame);
  }
  return kept;
}

struct CornerMean {
  Corners corners_px;
  double scatter_px = 0.0;
  Time capture_time;
};

CornerMean mean_of(const std::vector<LookFrame>& frames) {
  CornerMean mean;
  const double n = static_cast<double>(frames.size());
  Duration since_first{0};
  for (const LookFrame& frame : frames) {
    since_first += frame.capture_time - frames.front().capture_time;
    for (std::size_t c = 0; c < 4; ++c) mean.corners_px[c] += frame.corners_px[c] * (1.0 / n);
  }
  mean.capture_time = frames.front().capture_time + since_first / static_cast<Duration::rep>(frames.size());
  double squares = 0.0;
  for (const LookFrame& frame : frames) {
    for (std::size_t c = 0; c < 4; ++c) {
      const cv::Point2d off = frame.corners_px[c] - mean.corners_px[c];
      squares += off.dot(off);
    }
  }
  if (frames.size() > 1) mean.scatter_px = std::sqrt(squares / (8.0 * (n - 1.0)));
  return mean;
}

/// σ of a mean corner: the frames' noise shrinks with their number, what they share does not. Few frames tell their
/// noise badly, so the assumed one counts like four of them.
double corner_sigma(const CornerMean& mean, std::size_t frames, const LookOptions& options) {
  const double n = static_cast<double>(frames), prior = 4.0;
  const double variance = (prior * options.corner_sigma_px * options.corner_sigma_px +
                           (n - 1.0) * mean.scatter_px * mean.scatter_px) / (prior + n - 1.0);
  return std::sqrt(variance / n + options.corner_floor_px * options.corner_floor_px);
}

struct Choice {
  const PlanarPose* first;
  const PlanarPose* second;
  bool was_decided_by_prediction;
};

Choice choose(const PlanarSolutions& s, const Pose& T_H_M, const std::optional<Pose>& predicted_T_C_H,
              const LookOptions& options) {
  if (!s.second) return {&s.best, nullptr, false};
  if (s.delta_chi2 > options.clear_delta_chi2) return {&s.best, nullptr, false};
  if (predicted_T_C_H) {
    const Matrix3 predicted = predicted_T_C_H->R * T_H_M.R;
    const double best = rotation_angle(s.best.T_C_M.R, predicted),
                 second = rotation_angle(s.second->T_C_M.R, predicted);
    if (second - best > kDecisive_rad) return {&s.best, nullptr, true};
    if (best - second > kDecisive_rad) return {&*s.second, nullptr, true};
    if (second < best) return {&*s.second, &s.best, false};
  }
  return {&s.best, &*s.second, false};
}

}  // namespace

LookResult make_look(std::span<const LookFrame> frames, const MarkerConfig& marker, const Pose& T_H_M,
                     const Intrinsics& intrinsics, const std::optional<Pose>& predicted_T_C_H,
                     const LookOptions& options) {
  if (frames.empty()) return {std::nullopt, "the marker was not seen"};
  const std::vector<LookFrame> used = without_outliers(frames, options.outlier_px);
  if (2 * used.size() <= frames.size())
    return {std::nullopt, "the corners of the frames do not agree: the marker moved"};
  const CornerMean mean = mean_of(used);
  if (mean.scatter_px > options.still_px) return {std::nullopt, "the corners scatter too much: the marker moved"};
  const double sigma_px = corner_sigma(mean, used.size(), options);
  const auto solutions = solve_planar_pose(mean.corners_px, marker.side_m, intrinsics, sigma_px);
  if (!solutions) return {std::nullopt, "the corners are no picture of a square before the camera"};
  const Choice choice = choose(*solutions, T_H_M, predicted_T_C_H, options);

  const Pose T_M_H = T_H_M.inverse();
  LookMeasurement look;
  look.T_C_H = choice.first->T_C_M * T_M_H;  // F-V4
  if (choice.second) look.second_T_C_H = choice.second->T_C_M * T_M_H;
  look.covariance = hand_covariance(choice.first->T_C_M, T_H_M, choice.first->covariance);
  look.corners_px = mean.corners_px;
  look.reprojection_px = choice.first->rms_px;
  look.scatter_px = mean.scatter_px;
  look.delta_chi2 = solutions->delta_chi2;
  look.was_decided_by_prediction = choice.was_decided_by_prediction;
  look.capture_time = mean.capture_time;
  look.frames = static_cast<int>(used.size());
  look.id = marker.id;
  return {look, {}};
}

}  // namespace armsight::host
