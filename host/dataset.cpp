#include "host/dataset.hpp"

#include <cstdio>
#include <system_error>

#include "host/dataset_parts.hpp"

namespace armsight::host {

Dataset load_dataset(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw ConfigError(folder.string() + ": is not a folder");
  Dataset dataset;
  dataset.folder = folder;
  const DatasetColumns columns = read_dataset_yaml(folder, dataset);
  read_dataset_rows(columns, dataset);
  return dataset;
}

std::string dataset_yaml_for_robot(const RobotConfig& robot, const std::string& robot_file) {
  char noise[200];
  std::snprintf(
      noise, sizeof noise,
      "{known: true, sigma_m: 0, sigma_rad: 0, encoder_sigma_rad: %.17g, floor_m: %.17g, floor_rad: %.17g}",
      robot.filter.encoder_sigma_rad, robot.filter.floor_position_sigma_m, robot.filter.floor_rotation_sigma_rad);
  std::string offsets;
  for (const auto& name : robot.joint_names) offsets += (offsets.empty() ? "" : ", ") + name;
  return "# The pose of a look is the hand's (T_C_H): what was seen of the marker, T_H_M of the robot file taken off."
         "\ndataset: looks of " +
         robot.robot + "\nchains:\n  - {name: arm, robot_file: " + robot_file +
         "}\ncamera: {on: root}\ntargets:\n  - {name: \"" + std::to_string(robot.hand_marker.id) +
         "\", on: arm, kind: pose, fixed: true}\nnoise: " + noise + "\nlearn: {offsets: [" + offsets +
         "], scale: false, links: false}\n";
}

}  // namespace armsight::host
