// ur10e-chessboard: a camera on the wrist, a board that stands still; 23 pictures with six joint angles each.
#include "tools/convert/text_files.hpp"

namespace armsight::tools {
namespace {

constexpr const char* kJoints[] = {"shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"};

constexpr const char* kUr10eYaml = R"(dataset: ur10e-chessboard
chains:
  - name: arm
    base: {xyz_m: [0, 0, 0], rpy_rad: [0, 0, 3.141592653589793]}
    joints:
      - {name: shoulder_pan, xyz_m: [0, 0, 0.1807], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}
      - {name: shoulder_lift, xyz_m: [0, 0, 0], rpy_rad: [1.5707963267948966, 0, 0], axis: [0, 0, 1]}
      - {name: elbow, xyz_m: [-0.6127, 0, 0], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}
      - {name: wrist_1, xyz_m: [-0.57155, 0, 0.17415], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}
      - {name: wrist_2, xyz_m: [0, -0.11985, 0], rpy_rad: [1.5707963267948966, 0, 0], axis: [0, 0, 1]}
      - {name: wrist_3, xyz_m: [0, 0.11655, 0], rpy_rad: [1.5707963267948966, 3.141592653589793, 3.141592653589793], axis: [0, 0, 1]}
camera: {on: arm, intrinsics: camera.yaml}
targets:
  - {name: board, on: root, kind: chessboard, inner_columns: 9, inner_rows: 6, square_m: 0.027}
noise: {sigma_px: 0.3}
learn: {offsets: [shoulder_lift, elbow, wrist_1, wrist_2], folds: 4}
# The authors' own results, kept as they came: board in camera and wrist in world, m and rotation vector.
ignore_columns: [cPo_x, cPo_y, cPo_z, cPo_rx, cPo_ry, cPo_rz, fPe_x, fPe_y, fPe_z, fPe_rx, fPe_ry, fPe_rz]
)";

/// Numbers of a ViSP pose file: "data:" and one "- [value]" a row.
std::vector<std::string> pose_numbers(const Path& file) {
  std::vector<std::string> numbers;
  const auto lines = read_lines(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto open = lines[i].find('['), close = lines[i].find(']');
    if (open == std::string::npos || close == std::string::npos) continue;
    for (const auto& field : split(std::string_view(lines[i]).substr(open + 1, close - open - 1), ',')) {
      if (!field.empty()) numbers.push_back(checked_number(field, file, i + 1));
    }
  }
  if (numbers.size() != 6) refuse(file, 1, "must hold 6 numbers");
  return numbers;
}

/// The text between <key> and </key>, first occurrence.
std::string xml_value(const std::vector<std::string>& lines, const std::string& key, const Path& file) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto open = lines[i].find("<" + key + ">"), close = lines[i].find("</" + key + ">");
    if (open == std::string::npos || close == std::string::npos) continue;
    const std::string text = lines[i].substr(open + key.size() + 2, close - open - key.size() - 2);
    return checked_number(text, file, i + 1);
  }
  refuse(file, 1, key + ": is missing");
}

std::string camera_yaml(const Path& file) {
  const auto lines = read_lines(file);
  const auto value = [&](const char* key) { return xml_value(lines, key, file); };
  return "# ROS camera_info, from the set's camera.xml\nimage_width: " + value("image_width") +
         "\nimage_height: " + value("image_height") +
         "\ncamera_name: camera\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [" + value("px") + ", 0, " +
         value("u0") + ", 0, " + value("py") + ", " + value("v0") +
         ", 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, "
         "0, 0]\n";
}

}  // namespace

int convert_ur10e(const Path& source, const Path& target) {
  std::string rows = "image";
  for (const char* joint : kJoints) rows += std::string(",") + joint;
  rows += ",marker,cPo_x,cPo_y,cPo_z,cPo_rx,cPo_ry,cPo_rz,fPe_x,fPe_y,fPe_z,fPe_rx,fPe_ry,fPe_rz\n";
  std::filesystem::create_directories(target / "images");
  int count = 0;
  for (int k = 1; std::filesystem::exists(source / ("configuration_" + std::to_string(k))); ++k, ++count) {
    const std::string number = std::to_string(k), picture = "image-" + number + ".png";
    const Path file = source / ("configuration_" + number);
    const auto lines = read_lines(file);
    const auto joints = split(lines.empty() ? "" : lines[0], ',');
    if (joints.size() != 6) refuse(file, 1, "must hold 6 joint angles");
    for (const auto& q : joints) checked_number(q, file, 1);
    rows += picture + "," + join(joints) + ",board," + join(pose_numbers(source / ("pose_cPo_" + number + ".yaml"))) +
            "," + join(pose_numbers(source / ("pose_fPe_" + number + ".yaml"))) + "\n";
    std::filesystem::copy_file(source / picture, target / "images" / picture,
                               std::filesystem::copy_options::overwrite_existing);
  }
  if (count == 0) refuse(source / "configuration_1", 1, "is missing");
  write_file(target / "samples.csv", rows);
  write_file(target / "camera.yaml", camera_yaml(source / "camera.xml"));
  write_file(target / "dataset.yaml", kUr10eYaml);
  return count;
}

}  // namespace armsight::tools
