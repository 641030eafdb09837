#include "host/intrinsics.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <vector>

#include "protocol/config.hpp"

namespace armsight::host {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const YAML::Mark& mark, const std::string& what) {
  std::string where = file.string();
  if (!mark.is_null()) where += ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
  throw ConfigError(where + ": " + what);
}

YAML::Node need(const YAML::Node& root, const char* key, const std::filesystem::path& file) {
  const YAML::Node node = root[key];
  if (!node) refuse(file, root.Mark(), std::string(key) + ": is missing");
  return node;
}

template <typename T>
T number(const YAML::Node& node, const std::string& key, const std::filesystem::path& file) {
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    refuse(file, node.Mark(), key + " = " + (node.IsScalar() ? node.Scalar() : "…") + ": must be a number");
  }
}

/// The data of a ROS or OpenCV matrix: {rows, cols, data}; `count` 0: any.
std::vector<double> matrix_data(const YAML::Node& node, const std::string& key, std::size_t count,
                                const std::filesystem::path& file) {
  const YAML::Node data = node.IsMap() ? node["data"] : node;
  if (!data || !data.IsSequence()) refuse(file, node.Mark(), key + ".data: must be a list of numbers");
  std::vector<double> values;
  for (const YAML::Node& entry : data) values.push_back(number<double>(entry, key + ".data", file));
  if (count != 0 && values.size() != count) {
    refuse(file, data.Mark(), key + ".data: has " + std::to_string(values.size()) + " numbers: must have " +
                                  std::to_string(count));
  }
  return values;
}

YAML::Node parse(const std::filesystem::path& file) {
  try {
    const YAML::Node root = YAML::LoadFile(file.string());
    if (!root.IsMap()) throw ConfigError(file.string() + ": must hold camera intrinsics (ROS or OpenCV YAML)");
    return root;
  } catch (const YAML::BadFile&) {
    throw ConfigError(file.string() + ": cannot be read");
  } catch (const YAML::Exception& error) {
    refuse(file, error.mark, error.msg);
  }
}

}  // namespace

std::string broken_rule(const Intrinsics& k) {
  if (k.width < 16 || k.height < 16 || k.width > 16384 || k.height > 16384) {
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
  const YAML::Node root = parse(file);
  const bool is_ros = static_cast<bool>(root["distortion_model"]);
  if (is_ros && root["distortion_model"].Scalar() != "plumb_bob") {
    refuse(file, root["distortion_model"].Mark(),
           "distortion_model = " + root["distortion_model"].Scalar() + ": must be plumb_bob");
  }
  Intrinsics k;
  k.width = number<int>(need(root, "image_width", file), "image_width", file);
  k.height = number<int>(need(root, "image_height", file), "image_height", file);
  const YAML::Node camera = need(root, "camera_matrix", file);
  const std::vector<double> K = matrix_data(camera, "camera_matrix", 9, file);
  if (K[1] != 0.0 || K[3] != 0.0 || K[6] != 0.0 || K[7] != 0.0 || K[8] != 1.0) {
    refuse(file, camera.Mark(), "camera_matrix: must be [fx 0 cx; 0 fy cy; 0 0 1]");
  }
  k.fx = K[0];
  k.fy = K[4];
  k.cx = K[2];
  k.cy = K[5];
  const YAML::Node lens = need(root, "distortion_coefficients", file);
  const std::vector<double> distortion = matrix_data(lens, "distortion_coefficients", 0, file);
  if (distortion.size() != 4 && distortion.size() != 5) {
    refuse(file, lens.Mark(), "distortion_coefficients: has " + std::to_string(distortion.size()) +
                                  " numbers: must have 4 or 5 (k1 k2 p1 p2 k3)");
  }
  std::copy(distortion.begin(), distortion.end(), k.plumb_bob.begin());
  if (const std::string rule = broken_rule(k); !rule.empty()) refuse(file, camera.Mark(), rule);
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
