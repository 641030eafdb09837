#include "protocol/config_values.hpp"

#include <array>
#include <numbers>
#include <utility>

namespace armsight {

Vector3 read_vector(const YamlValue& value, double max) {
  const std::vector<double> v = value.numbers(3, -max, max);
  return {v[0], v[1], v[2]};
}

Pose read_frame(const YamlValue& value) {
  Pose T;
  T.p = read_vector(value.key("xyz_m"), 10);
  const Vector3 rpy_rad = read_vector(value.key("rpy_rad"), 2 * std::numbers::pi);
  T.R = (Eigen::AngleAxisd(rpy_rad.z(), Vector3::UnitZ()) * Eigen::AngleAxisd(rpy_rad.y(), Vector3::UnitY()) *
         Eigen::AngleAxisd(rpy_rad.x(), Vector3::UnitX()))
            .toRotationMatrix();
  return T;
}

Pose read_pose(const YamlValue& value) {
  Pose T;
  T.p = read_vector(value.key("position_m"), 10);
  const YamlValue rows = value.key("rotation_rows");
  Eigen::Index i = 0;
  T.R.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (const YamlValue& row : rows.list(3, 3)) T.R.row(i++) = read_vector(row, 10).transpose();
  if (!T.R.allFinite()) return {};  // its cause has been told
  if (!is_rotation(T.R, 1e-6)) {
    rows.refuse("must be a rotation: rows orthonormal and right-handed to 1e-6");
    return {};
  }
  T.R = nearest_rotation(T.R);
  return T;
}

int marker_dictionary_size(std::string_view dictionary) {
  constexpr std::array<std::pair<std::string_view, int>, 5> kOthers{{{"DICT_ARUCO_ORIGINAL", 1024},
                                                                     {"DICT_APRILTAG_16h5", 30},
                                                                     {"DICT_APRILTAG_25h9", 35},
                                                                     {"DICT_APRILTAG_36h10", 2320},
                                                                     {"DICT_APRILTAG_36h11", 587}}};
  for (const auto& [name, size] : kOthers)
    if (dictionary == name) return size;
  for (const char bits : {'4', '5', '6', '7'})
    for (const int size : {50, 100, 250, 1000})
      if (dictionary == std::string("DICT_") + bits + "X" + bits + "_" + std::to_string(size)) return size;
  return 0;
}

}  // namespace armsight
