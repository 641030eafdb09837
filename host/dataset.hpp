// A folder with recorded looks → the problem of host/chain_problem.hpp. The format is host/DATASET.md; everything is
// read strictly, all violations told with file, line, column and rule.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/chain_problem.hpp"
#include "protocol/config.hpp"

namespace armsight::host {

enum class TargetKind { kPose, kSquare, kPoints, kChessboard, kMarker };

struct DatasetTarget {
  TargetKind kind = TargetKind::kPose;
  double side_m = 0.0;             ///< square, marker
  int board_columns = 0, board_rows = 0;  ///< inner corners of a chessboard
  double square_m = 0.0;
  std::string dictionary;          ///< marker in a picture
  int id = 0;
};

/// Where the arm was, in its own clock: stream of arm.csv.
struct ArmStream {
  std::vector<double> time_s;          ///< rising; repeated stamps may occur
  std::vector<Eigen::VectorXd> q;      ///< of the problem's joints; empty where poses are given
  std::vector<Pose> T_0_given;
};

struct LeftOut {
  std::string label, reason;
};

struct Dataset {
  std::string name;
  std::filesystem::path folder;
  ChainModel model;                    ///< mounts at the starts given, offsets fixed at 0, scales fixed at 1
  std::vector<DatasetTarget> targets;  ///< as model.targets
  std::vector<Observation> observations;
  std::vector<double> look_time_s;     ///< of each observation, empty without times
  std::vector<LeftOut> left_out;       ///< rows that gave no observation
  int rows = 0;                        ///< looks in the file
  std::optional<ArmStream> stream;     ///< two-stream sets: q and T_0_given of the looks come from here
  double max_offset_s = 0.5;
  NoiseModel noise;
  double sigma_m = 0.003, sigma_rad = 0.0087, sigma_px = 0.3;  ///< of looks that bring no covariance
  bool noise_is_known = false;         ///< else the figures are a start, and the residuals tell
  std::vector<int> offset_joints;      ///< whose zeros may be wrong, joints of the problem
  bool may_learn_scale = true, may_learn_links = true, may_learn_intrinsics = true;
  int folds = 5;
};

/// Throws ConfigError.
Dataset load_dataset(const std::filesystem::path& folder);

/// dataset.yaml of looks made with an Armsight robot: chain "arm" of `robot_file`, a name inside the folder,
/// and hand poses.
std::string dataset_yaml_for_robot(const RobotConfig& robot, const std::string& robot_file);

}  // namespace armsight::host
