// How good was the run? What the programs believed against the simulator's truth, by the definitions of the
// specification (§§5.3, 7): errors of the hand pose seen by the camera, so that no choice of gauge enters.
#pragma once

#include "protocol/config.hpp"
#include "tools/report/results.hpp"

namespace armsight::demo {

struct PoseError {
  double mm = 0, deg = 0;
};
/// Norms of (5.17) and of the rotation angle.
PoseError error_between(const Pose& a, const Pose& b);

/// The demo's experiment: commanded poses and how the held-out postures are drawn.
struct Experiment {
  std::vector<JointVector> commanded_q_real;
  std::string object;
  int heldout_postures = 0;
  std::uint64_t heldout_seed = 0;
  double heldout_distance_rad = 0;      ///< at least so far, in some joint, from every look
  double view_x = 0, view_y = 0;        ///< visible: |x/z|, |y/z| of the marker below these
  double min_depth_m = 0, max_depth_m = 0;
  double max_tilt_rad = 0;
};
Experiment load_experiment(const std::filesystem::path& file, const RobotConfig& robot);

/// The truth's row at a sampling instant (nearest, at most half a period away); throws std::runtime_error.
const TruthRow& row_at(const Truth& truth, std::int64_t arm_time_ns);
/// True pose of the hand in the camera then, with the camera that stood there then.
Pose true_T_C_H(const Truth& truth, std::int64_t arm_time_ns);

struct HeldOut {
  int postures = 0;
  double rms_mm = 0, rms_deg = 0;
};
/// Model against truth before the drift, over visible random postures never looked at; readings without noise.
HeldOut evaluate_heldout(const Truth& truth, const LearnedModel& model, const std::vector<CalibrationLook>& looks,
                         const RobotConfig& robot, const Experiment& experiment);

struct GaugeAligned {
  std::vector<std::optional<double>> beta_error_deg;  ///< model − truth; empty where unobservable
  PoseError camera;                                   ///< of T_C_B, after the base was turned about joint 1
};
/// T_C_B Rz(s) Λ(q1 − s, …) = T_C_B Λ(q): the truth is brought to the model's β₁ first (specification §5.3).
GaugeAligned evaluate_parameters(const LearnedModel& truth, const CalibrateResult& result, const SerialChain& chain);

struct CommandedPose {
  Pose T_C_G, T_C_H;        ///< commanded (by the model in force), true
  PoseError model_error;    ///< the model's hand pose at the reading against the true one at that instant (E3)
  PoseError reached_error;  ///< true against commanded
};
CommandedPose evaluate_move(const Truth& truth, const MoveResult& move, const SerialChain& nominal);

/// Median over the moves of the model's error, were `model` in force.
PoseError median_error(const Truth& truth, const std::vector<MoveResult>& moves, const LearnedModel& model,
                       const SerialChain& nominal);
/// Throws std::invalid_argument for no values: nothing measured is no perfect score.
double median(std::vector<double> values);
/// Medians of the model's errors.
PoseError median_model_error(const std::vector<CommandedPose>& poses);

struct GraspEvaluation {
  bool was_closed = false;          ///< the hand closed at the goal: truth knows the attempt
  PoseError error;                  ///< true hand pose against the nearest true grasp pose
  bool is_success = false;          ///< held, within 10 mm and 5°
  bool does_verdict_agree = false;  ///< the host's verdict with the truth
  Pose T_G_computed, T_G_reached;   ///< computed goal and final hand, seen from the nearest true grasp pose
};
/// The attempt's own entry among the truth's grasps is the nearest in time.
GraspEvaluation evaluate_grasp(const Truth& truth, const GraspResult& grasp);

}  // namespace armsight::demo
