// Light on the sensor → 8-bit picture: defocus, uneven light, exposure, photon and read noise.
#pragma once

#include <opencv2/core/mat.hpp>
#include <random>
#include <vector>

#include "tools/sim/scene.hpp"

namespace armsight::sim {

class Optics {
 public:
  Optics(const CameraOptics& camera, const Light& light, std::uint64_t seed);
  /// CV_32FC1 grey levels → CV_8UC1. Noise is drawn anew each time.
  cv::Mat develop(const cv::Mat& grey);

 private:
  CameraOptics camera_;
  cv::Mat light_;             ///< CV_32FC1, factor a pixel
  std::vector<float> noise_;  ///< unit normal numbers; every row reads them from a drawn place
  std::mt19937_64 random_;
  cv::Mat blurred_;
};

}  // namespace armsight::sim
