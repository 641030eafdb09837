// What Learn leaves on disk: its looks as a data set (STATE/looks, for `host calibrate --dataset`), written as they are
// made, and the calibration that came of them.
#pragma once

#include <filesystem>
#include <string>

#include "host/calibration_problem.hpp"
#include "protocol/config.hpp"

namespace armsight::host {

class LookFiles {
 public:
  /// Starts a new data set in the folder. Throws ConfigError where it cannot be written.
  LookFiles(const std::filesystem::path& folder, const RobotConfig& robot, const std::filesystem::path& robot_file);
  void add(const LookSample& sample);

 private:
  std::filesystem::path folder_;
  Pose T_H_M_;
  int marker_id_;
  std::string rows_;
};

/// STATE/calibration.yaml: the model in force after Learn, with its covariance and its figures.
void save_calibration(const std::filesystem::path& file, const RobotConfig& robot, const LearnedModel& model,
                      const ArmCalibration& calibration);

}  // namespace armsight::host
