// How wrong is the simulated robot? The noise sets of specification §7.1, one row a set. SI units, 1σ unless named max.
#pragma once

#include <optional>
#include <string_view>

#include "shared/geometry.hpp"

namespace armsight::sim {

enum class NoiseSet { kClean, kNominal, kHard };

struct NoiseFigures {
  double corner_px;                 ///< white noise of a marker corner, per frame
  double corner_bias_px;            ///< constant per look
  double encoder_rad;               ///< per look: a smooth function of position
  double encoder_jitter_rad;        ///< per sample
  double marker_mount_m, marker_mount_rad;          ///< size of the error of T_H_M
  double link_m;                    ///< per link
  double servo_residual_rad;        ///< standing error of a drive's position loop
  double beta_max_rad;              ///< joint offsets at Learn, uniform
  double camera_max_m, camera_max_rad;              ///< camera beside its nominal mount
  double drift_camera_m, drift_camera_rad, drift_beta_max_rad;  ///< between Learn and Adapt
};

constexpr NoiseFigures noise_figures(NoiseSet set) {
  switch (set) {
    case NoiseSet::kClean:
      return {0.25, 0.0, 0.05 * kDegree, 0.0, 0.0, 0.0, 0.0, 0.0, 8 * kDegree, 0.05, 10 * kDegree, 0.0, 0.0, 0.0};
    case NoiseSet::kNominal:
      return {0.25, 0.15, 0.10 * kDegree, 0.02 * kDegree, 0.0005, 0.3 * kDegree, 0.0, 0.10 * kDegree,
              8 * kDegree, 0.05, 10 * kDegree, 0.015, 3 * kDegree, 2 * kDegree};
    case NoiseSet::kHard:
      return {0.5, 0.3, 0.15 * kDegree, 0.02 * kDegree, 0.001, 0.5 * kDegree, 0.001, 0.20 * kDegree,
              8 * kDegree, 0.05, 10 * kDegree, 0.030, 6 * kDegree, 5 * kDegree};
  }
  return {};
}

constexpr const char* to_text(NoiseSet set) {
  return set == NoiseSet::kClean ? "clean" : set == NoiseSet::kNominal ? "nominal" : "hard";
}

constexpr std::optional<NoiseSet> noise_set_from_text(std::string_view text) {
  for (NoiseSet set : {NoiseSet::kClean, NoiseSet::kNominal, NoiseSet::kHard})
    if (text == to_text(set)) return set;
  return std::nullopt;
}

}  // namespace armsight::sim
