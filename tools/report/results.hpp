// What a run left behind, as plain structs: the results of the host's verbs and the simulator's truth.
// SI units and radians but where a name says otherwise. Files and keys: tools/README.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/arm_model.hpp"

namespace armsight::demo {

struct CalibrationLook {
  JointVector q_reading;
  std::int64_t arm_time_ns = 0;
  bool is_used = false;
  std::string reason, image;
  double residual_mm = 0, residual_deg = 0, reprojection_px = 0;
};
struct CalibrateResult {
  std::vector<CalibrationLook> looks;
  double training_mm = 0, training_deg = 0;
  double crossvalidation_mm = 0,
         crossvalidation_deg = 0;  ///< k-fold over the looks, against the camera's own measurements
  std::vector<std::optional<double>> sigma_beta_deg;       ///< empty where unobservable
  std::optional<double> sigma_camera_mm, sigma_camera_deg;
  int rank = 0, parameters = 0, attempts = 0;
  std::vector<std::string> unobservable;
  double solve_wall_ms = 0;
  LearnedModel model;
};

struct AdaptLook {
  std::string outcome, image;
  double nis = 0, cost = 0, gain_norm = 0;
  int iterations = 0;
  Vector6 innovation = Vector6::Zero();
  JointVector q_reading, delta_beta;
  Vector3 delta_t_m = Vector3::Zero(), delta_theta_rad = Vector3::Zero();
  std::int64_t arm_time_ns = 0;
  LearnedModel model;  ///< after the look
};
struct AdaptResult {
  LearnedModel before, after;
  std::vector<AdaptLook> looks;
};

struct MoveResult {
  JointVector q_goal_real, q_reading;
  std::string state;
  std::int64_t arm_time_ns = 0;
  LearnedModel model;
};

struct GraspResult {
  std::string object, candidate, status, verdict, why;
  Pose T_C_O, T_O_G, T_B_G;
  LearnedModel model;
  std::int64_t arm_time_ns = 0;
  JointVector q_reading;
  double hand_closure = 0, hand_effort_permille = 0;
  std::vector<std::string> images;
  std::string image_closed;  ///< of these: after the hand closed; empty where it did not
};

struct TruthRow {
  std::int64_t arm_time_ns = 0;
  JointVector q_true, q_reading;
  Pose T_B_H;
};
struct TruthGrasp {
  std::int64_t arm_time_ns = 0;
  bool is_held = false;
  double error_m = 0, error_rad = 0;
};
struct Truth {
  SerialChain chain;
  LearnedModel before, after;       ///< true camera and joint offsets before and after the drift
  std::int64_t drift_arm_time_ns = 0;
  Pose T_B_O;
  std::vector<TruthGrasp> grasps;
  std::vector<TruthRow> rows;       ///< one a SYNC, times rising
};

/// One histogram of the controller's cycles: so many durations up to each edge, above the edge before.
struct DurationRow {
  std::string name;
  std::uint64_t count = 0;
  double p50_us = 0, p999_us = 0, max_us = 0;
  std::vector<std::uint64_t> upper_ns, counts;
};
struct ControllerStatus {
  double rate_hz = 0, tick_us_p50 = 0, tick_us_p999 = 0;
  std::uint64_t cycles = 0, missed = 0;
  std::vector<DurationRow> durations;
};

/// Throw std::runtime_error "FILE: KEY: what is wrong".
CalibrateResult load_calibrate(const std::filesystem::path& file);
AdaptResult load_adapt(const std::filesystem::path& file);
MoveResult load_move(const std::filesystem::path& file);
GraspResult load_grasp(const std::filesystem::path& file);
/// Of `host status --out`.
ControllerStatus load_status(const std::filesystem::path& file);
/// truth.json and the truth.csv it names.
Truth load_truth(const std::filesystem::path& file);

}  // namespace armsight::demo
