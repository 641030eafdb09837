// talos-pyrene-apriltag: head camera, tags on both wrists; facts of the arm from the set's README.
#include "tools/convert/text_files.hpp"

namespace armsight::tools {
namespace {

std::string arm_chain(const std::string& side, const char* sign) {
  const std::string j = "arm_" + side + "_";
  return "  - name: arm_" + side + "\n    joints:\n" + "      - {name: " + j + "1_joint, xyz_m: [0, " + sign +
         "0.1575, 0.232], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}\n" + "      - {name: " + j +
         "2_joint, xyz_m: [0.00493, " + sign + "0.1365, 0.04673], rpy_rad: [0, 0, 0], axis: [1, 0, 0]}\n" +
         "      - {name: " + j + "3_joint, xyz_m: [0, 0, 0], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}\n" +
         "      - {name: " + j + "4_joint, xyz_m: [0.02, 0, -0.273], rpy_rad: [0, 0, 0], axis: [0, 1, 0]}\n" +
         "      - {name: " + j + "5_joint, xyz_m: [-0.02, 0, -0.2643], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}\n" +
         "      - {name: " + j + "6_joint, xyz_m: [0, 0, 0], rpy_rad: [0, 0, 0], axis: [1, 0, 0]}\n" +
         "      - {name: " + j + "7_joint, xyz_m: [0, 0, 0], rpy_rad: [0, 0, 0], axis: [0, 1, 0]}\n";
}

bool is_calibrated(const std::string& joint) { return joint.rfind("arm_", 0) == 0 || joint.rfind("head_", 0) == 0; }

std::string dataset_yaml(const std::vector<std::string>& joints, const std::string& csv) {
  std::string offsets, ignored;
  for (const auto& joint : joints) (is_calibrated(joint) ? offsets : ignored) += ", " + joint;
  return "dataset: talos-pyrene-apriltag, " + csv +
         "\n# Both chains start in torso_2_link; torso and legs do not move what the camera sees.\nchains:\n"
         "  - name: head\n    joints:\n"
         "      - {name: head_1_joint, xyz_m: [0.02, 0, 0.321], rpy_rad: [0, 0, 0], axis: [0, 1, 0]}\n"
         "      - {name: head_2_joint, xyz_m: [0, 0, 0], rpy_rad: [0, 0, 0], axis: [0, 0, 1]}\n" +
         arm_chain("left", "") + arm_chain("right", "-") +
         "camera: {on: head}\ntargets:\n"
         "  - {name: left_gripper, on: arm_left, kind: pose, start: {xyz_m: [0, 0, -0.092], rpy_rad: [0, 0, 0]}}\n"
         "  - {name: right_gripper, on: arm_right, kind: pose, start: {xyz_m: [0, 0, -0.092], quat_wxyz: [0, 0, 0, "
         "1]}}\n"
         "noise: {sigma_m: 0.008, sigma_rad: 0.02}   # what the mounts-only fit leaves, roughly\n"
         "learn:\n  scale: true\n  offsets: [" +
         offsets.substr(2) + "]\nignore_columns: [" + ignored.substr(2) + "]\n";
}

}  // namespace

int convert_talos(const Path& source, const std::string& csv, const Path& target) {
  const Path file = source / csv;
  const auto lines = read_lines(file);
  if (lines.empty()) refuse(file, 1, "must begin with joint_names");
  auto names = split(lines[0], ',');
  if (names[0] != "joint_names" || names.size() < 2) refuse(file, 1, "must begin with joint_names");
  names.erase(names.begin());
  std::string rows = join(names) + ",marker,x_m,y_m,z_m,qx,qy,qz,qw\n";
  int count = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    auto fields = split(lines[i], ',');
    if (fields[0] != "joint_states" || fields.size() != names.size() + 9) {
      refuse(file, i + 1, "must be joint_states, a reading a joint, the gripper and 7 numbers");
    }
    fields.erase(fields.begin());
    for (std::size_t k = 0; k < fields.size(); ++k) {
      if (k != names.size()) checked_number(fields[k], file, i + 1);
    }
    rows += join(fields) + "\n";
    ++count;
  }
  write_file(target / "samples.csv", rows);
  write_file(target / "dataset.yaml", dataset_yaml(names, csv));
  return count;
}

}  // namespace armsight::tools
