#include "tools/sim/optics.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace armsight::sim {
namespace {

constexpr std::size_t kNoiseNumbers = 1U << 20;

cv::Mat light_map(const CameraOptics& camera, const Light& light) {
  const host::Intrinsics& k = camera.intrinsics;
  cv::Mat map(k.height, k.width, CV_32FC1);
  const double corner2 = 0.25 * (k.width * k.width + k.height * k.height);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.cols; ++column) {
      const double x = column - 0.5 * k.width, y = row - 0.5 * k.height;
      const double fall = 1.0 - light.vignetting * (x * x + y * y) / corner2;
      const double slope = 1.0 + light.gradient * x / k.width;
      map.at<float>(row, column) = static_cast<float>(light.exposure_gain * fall * slope);
    }
  }
  return map;
}

}  // namespace

Optics::Optics(const CameraOptics& camera, const Light& light, std::uint64_t seed)
    : camera_(camera), light_(light_map(camera, light)), noise_(kNoiseNumbers), random_(seed) {
  std::normal_distribution<float> normal;
  for (float& number : noise_) number = normal(random_);
}

cv::Mat Optics::develop(const cv::Mat& grey) {
  const double sigma = camera_.defocus_px;
  if (sigma > 0.0) {
    const int taps = 2 * static_cast<int>(std::ceil(3.0 * sigma)) + 1;
    cv::GaussianBlur(grey, blurred_, cv::Size(taps, taps), sigma, sigma, cv::BORDER_REPLICATE);
  } else {
    blurred_ = grey;
  }
  cv::Mat picture(grey.size(), CV_8UC1);
  const float read = static_cast<float>(camera_.read_noise_levels * camera_.read_noise_levels);
  const float shot = static_cast<float>(camera_.shot_noise_levels);
  std::uniform_int_distribution<std::size_t> place(0, kNoiseNumbers - static_cast<std::size_t>(grey.cols) - 1);
  for (int row = 0; row < grey.rows; ++row) {
    const float* in = blurred_.ptr<float>(row);
    const float* light = light_.ptr<float>(row);
    const float* noise = noise_.data() + place(random_);
    unsigned char* out = picture.ptr(row);
    for (int column = 0; column < grey.cols; ++column) {
      const float level = in[column] * light[column];
      const float noisy = level + noise[column] * std::sqrt(read + shot * level) + 0.5F;
      out[column] = static_cast<unsigned char>(noisy < 0.0F ? 0.0F : noisy > 255.0F ? 255.0F : noisy);
    }
  }
  return picture;
}

}  // namespace armsight::sim
