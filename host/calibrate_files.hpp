// What Learn leaves on disk: its looks as a data set (STATE/looks, for `host calibrate --dataset`), written as they are
// made, and the calibration that came of them. The looks hold what the solver was given, to the last bit: the hand's
// pose, its second solution and its covariance.
#pragma once

#include <filesystem>
#include <string>

#include "host/learn_arm.hpp"
#include "protocol/config.hpp"

namespace armsight::host {

class LookFiles {
 public:
  /// Touches nothing yet: the last run's looks stand until the first new one is on disk; then they are FOLDER-previous.
  LookFiles(const std::filesystem::path& folder, const RobotConfig& robot, const std::filesystem::path& robot_file);
  /// Throws std::runtime_error where the folder cannot be written.
  void add(const LookSample& sample);

 private:
  void begin() const;

  std::filesystem::path folder_;
  std::string robot_, dataset_, marker_, rows_;
  bool has_begun_ = false;
};

/// STATE/calibration.yaml: the model in force after Learn, with its covariance and its figures.
void save_calibration(const std::filesystem::path& file, const RobotConfig& robot, const LearnedModel& model,
                      const ArmCalibration& calibration);

}  // namespace armsight::host
