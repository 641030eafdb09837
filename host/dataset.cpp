#include "host/dataset.hpp"

#include <cstdio>

#include "host/dataset_parts.hpp"

namespace armsight::host {

Dataset load_dataset(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) throw ConfigError(folder.string() + ": is not a folder");
  Dataset dataset;
  dataset.folder = folder;
  const DatasetColumns columns = read_dataset_yaml(folder, dataset);
  read_dataset_rows(columns, dataset);
  return dataset;
}

std::string dataset_yaml_for_robot(const RobotConfig& robot, const std::string& robot_file) {
  const Pose& T = robot.arm.T_H_M;
  const Eigen::Quaterniond quat(T.R);
  char start[320];
  std::snprintf(start, sizeof start, "{xyz_m: [%.17g, %.17g, %.17g], quat_wxyz: [%.17g, %.17g, %.17g, %.17g]}", T.p.x(),
                T.p.y(), T.p.z(), quat.w(), quat.x(), quat.y(), quat.z());
  char noise[200];
  std::snprintf(noise, sizeof noise, "{sigma_m: 0, sigma_rad: 0, encoder_sigma_rad: %.17g, floor_m: %.17g, floor_rad: %.17g}",
                robot.filter.encoder_sigma_rad, robot.filter.floor_position_sigma_m, robot.filter.floor_rotation_sigma_rad);
  std::string offsets;
  for (const auto& name : robot.joint_names) offsets += (offsets.empty() ? "" : ", ") + name;
  return "dataset: looks of " + robot.robot + "\nchains:\n  - {name: arm, robot_file: " + robot_file +
         "}\ncamera: {on: root}\ntargets:\n  - {name: \"" + std::to_string(robot.hand_marker.id) +
         "\", on: arm, kind: pose, fixed: true,\n     start: " + start + "}\nnoise: " + noise + "\nlearn: {offsets: [" +
         offsets + "]}\n";
}

}  // namespace armsight::host
