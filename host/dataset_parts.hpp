// Pieces of load_dataset, one file each: dataset.yaml, samples.csv or arm.csv and looks.csv, the pictures.
#pragma once

#include "host/csv_table.hpp"
#include "host/dataset.hpp"

namespace armsight::host {

struct DatasetColumns {
  std::vector<std::string> ignored;
};

/// Fills everything but the looks from dataset.yaml; returns the columns it declares unread.
DatasetColumns read_dataset_yaml(const std::filesystem::path& folder, Dataset& dataset);

/// samples.csv, or arm.csv and looks.csv.
void read_dataset_rows(const DatasetColumns& columns, Dataset& dataset);

/// Corners of one target in one picture of the folder; nullopt where it is not found. Throws ConfigError
/// where there is no picture.
std::optional<std::vector<Eigen::Vector2d>> corners_in_picture(const Dataset& dataset, const DatasetTarget& target,
                                                               const std::string& picture);
/// Corner points of a square, marker or chessboard on the target, in the order of corners_in_picture.
std::vector<Vector3> points_of(const DatasetTarget& target);

/// Fills T_C_M of a look with corners; false where the corners give no pose in front of the camera.
bool start_pose_from_corners(const Intrinsics& camera, Observation& z);

}  // namespace armsight::host
