// The files of a run that never happened, with errors we know: what evaluation and report are tested with.
#pragma once

#include <filesystem>

#include "protocol/config.hpp"
#include "tools/report/evaluation.hpp"
#include "tools/report/results.hpp"

namespace armsight::demo {

struct SyntheticRun {
  SyntheticRun(const RobotConfig& robot, const Experiment& experiment);
  /// truth.json, truth.csv, calibrate.json, adapt.json, move-(without|with)-N.json, grasp-(without|with).json.
  void write(const std::filesystem::path& folder) const;

  const RobotConfig& robot;
  const Experiment& experiment;
  LearnedModel true_before, true_after;
  LearnedModel learnt, adapted;
  double grasp_error_with_m = 0.002, grasp_error_without_m = 0.018;
};

}  // namespace armsight::demo
