#include "host/intrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

constexpr int kLeastSide_px = 16, kMostSide_px = 16384;
constexpr double kLargest = 1e6;  // of any number here; the rules of broken_rule are narrower

/// The data of a ROS or OpenCV matrix, {rows, cols, data}; empty: a violation was recorded.
std::vector<double> matrix_data(const YamlValue& matrix, std::size_t min_size, std::size_t max_size) {
  std::vector<double> values;
  for (const YamlValue& entry : matrix.key("data").list(min_size, max_size)) {
    values.push_back(entry.number(-kLargest, kLargest));
  }
  matrix.ignore_other_keys();
  return values;
}

bool is_pinhole(const std::vector<double>& K) {
  return K[1] == 0.0 && K[3] == 0.0 && K[6] == 0.0 && K[7] == 0.0 && K[8] == 1.0;
}

}  // namespace

std::string broken_rule(const Intrinsics& k) {
  if (std::min(k.width, k.height) < kLeastSide_px || std::max(k.width, k.height) > kMostSide_px) {
    return "image size = " + std::to_string(k.width) + " x " + std::to_string(k.height) + ": must be 16 to 16384 px";
  }
  for (const double value : {k.fx, k.fy, k.cx, k.cy, k.plumb_bob[0], k.plumb_bob[1], k.plumb_bob[2], k.plumb_bob[3],
                             k.plumb_bob[4]}) {
    if (!std::isfinite(value)) return "a number is not finite";
  }
  if (k.fx <= 0.0 || k.fy <= 0.0) return "fx, fy: must be > 0";
  if (k.cx < 0.0 || k.cx > k.width || k.cy < 0.0 || k.cy > k.height) return "cx, cy: must lie in the picture";
  return {};
}

Intrinsics load_intrinsics(const std::filesystem::path& file) {
  const StrictYaml yaml = StrictYaml::parse(read_text_file(file), file.string());
  const YamlValue root = yaml.root();
  Intrinsics k;
  k.width = static_cast<int>(root.key("image_width").integer(kLeastSide_px, kMostSide_px));
  k.height = static_cast<int>(root.key("image_height").integer(kLeastSide_px, kMostSide_px));
  const YamlValue model = root.optional_key("distortion_model");  // ROS names it, OpenCV knows this one alone
  if (model.exists() && model.text() != "plumb_bob") model.refuse("must be plumb_bob");
  const YamlValue camera = root.key("camera_matrix");
  const std::vector<double> K = matrix_data(camera, 9, 9);
  const std::vector<double> lens = matrix_data(root.key("distortion_coefficients"), 4, 5);
  root.ignore_other_keys();
  yaml.finish();
  k.fx = K[0];
  k.fy = K[4];
  k.cx = K[2];
  k.cy = K[5];
  std::copy(lens.begin(), lens.end(), k.plumb_bob.begin());
  if (!is_pinhole(K)) camera.refuse("must be [fx 0 cx; 0 fy cy; 0 0 1]");
  else if (const std::string rule = broken_rule(k); !rule.empty()) camera.refuse(rule);
  yaml.finish();
  return k;
}

Eigen::Vector2d distort(const Intrinsics& k, const Eigen::Vector2d& xy) {
  const auto& [k1, k2, p1, p2, k3] = k.plumb_bob;
  const double x = xy.x(), y = xy.y(), r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

Eigen::Vector2d undistort(const Intrinsics& k, const cv::Point2d& pixel) {
  const Eigen::Vector2d distorted((pixel.x - k.cx) / k.fx, (pixel.y - k.cy) / k.fy);
  Eigen::Vector2d xy = distorted;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d step = distorted - distort(k, xy);
    xy += step;
    if (step.squaredNorm() < 1e-24) break;
  }
  return xy;
}

cv::Point2d to_pixel(const Intrinsics& k, const Eigen::Vector2d& xy) {
  const Eigen::Vector2d d = distort(k, xy);
  return {k.fx * d.x() + k.cx, k.fy * d.y() + k.cy};
}

cv::Point2d project(const Intrinsics& k, const Vector3& p_C) { return to_pixel(k, p_C.head<2>() / p_C.z()); }

}  // namespace armsight::host
