// The run as a reader sees it: report.json for programs, report.html for people; figures as chapter 8 has them.
#pragma once

#include <map>

#include "tools/report/evaluation.hpp"
#include "tools/report/svg_plot.hpp"

namespace armsight::demo {

struct Phase {
  std::string name;
  double simulated_s = 0, wall_s = 0;
};
struct ReportImage {
  std::string caption;
  std::filesystem::path file;  ///< JPEG or PNG
};
/// What the controller says of its cycles.
struct ControllerFigures : ControllerStatus {
  std::vector<std::string> black_boxes;  ///< files: a fault writes one, and a run without watchdogs has none
};

struct Report {
  std::uint64_t seed = 0;
  std::string noise, bus, bus_line, pace, robot_name, object;
  std::map<std::string, std::string> versions;  ///< program → version

  CalibrateResult calibrate;
  HeldOut heldout;
  GaugeAligned parameters;

  AdaptResult adapt;
  std::vector<CommandedPose> without_filter, with_filter;
  std::vector<PoseError> after_looks;              ///< median over the commanded poses after 0, 1, … looks
  std::vector<std::vector<double>> after_looks_mm_each;  ///< [pose][looks]
  std::vector<std::vector<Vector3>> arm_in_camera;  ///< shoulder, elbow, hand of each commanded pose, in C

  GraspResult grasp_without, grasp_with;
  GraspEvaluation without_grasp, with_grasp;

  ControllerFigures controller;
  std::vector<Phase> phases;
  std::vector<ReportImage> images;
  std::vector<std::string> commands;                          ///< command lines of the run
  std::vector<std::pair<std::string, std::string>> inputs;    ///< file name → its text, as used
};

/// Fills what follows from results, truth and robot; results, run facts and images are in `report` already.
void evaluate(Report& report, const Truth& truth, const std::vector<MoveResult>& moves_without,
              const std::vector<MoveResult>& moves_with, const RobotConfig& robot, const Experiment& experiment);

/// Deterministic but for solve_ms, tick_us_* and keys that end in _wall_s.
std::string to_json(const Report& report);
std::string to_html(const Report& report);

// Figures 8.4 to 8.7 and the calibration's.
std::vector<Plot> calibration_figures(const Report& report);
std::vector<Plot> commanded_pose_figures(const Report& report);    // 8.4
std::vector<Plot> error_figures(const Report& report);             // 8.5
std::vector<Plot> filter_figures(const Report& report);            // 8.6
std::vector<Plot> grasp_figures(const Report& report);             // 8.7
/// How the durations of the cycle are spread.
std::vector<Plot> controller_figures(const Report& report);

}  // namespace armsight::demo
