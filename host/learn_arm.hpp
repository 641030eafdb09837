// Learn on the default arm: camera-base pose and joint offsets from looks at the hand, thesis ch. 4, with the
// weights of specification §5.4, the gauge of §5.3 and an answer that can be refused (F-C5, F-C8, E2).
// The general problem behind it (chains of cameras and targets) is host/chain_problem.hpp.
// Poses as in shared/geometry.hpp; metres, radians; covariances in C, rows position then rotation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/batch_calibration.hpp"

namespace armsight::host {

/// One accepted look: what the camera measured and what the encoders said at mid-exposure.
struct LookSample {
  JointVector q_reading;                 ///< rad, without beta
  Pose T_C_H;                            ///< hand pose by vision
  std::optional<Pose> T_C_H_second;      ///< the other planar solution, as hand pose
  Matrix6 R_vision = Matrix6::Zero();    ///< covariance of T_C_H from the corners alone
  std::int64_t arm_time_ns = 0;
  std::string image;                     ///< name of the saved picture, may be empty
};

struct CalibrationOptions {
  LearnCost cost = LearnCost::kLikelihood;
  bool with_offsets = true;              ///< false: camera-base only, for comparison
  double encoder_sigma_rad = 0.00175;    ///< R_q of one look, per joint
  double floor_position_sigma_m = 0.001;
  double floor_rotation_sigma_rad = 0.00524;
  double beta1_sigma_rad = 0.0087;       ///< what the covariance says about the held beta_1 (gauge)
  int folds = 5;
  unsigned fold_seed = 1;
  int min_looks = 6;
  double max_beta_sigma_rad = 0.026;     ///< 1.5°: looser than this is called not observable enough
  double max_misfit = 3.0;               ///< rms of whitened residuals; above: the looks contradict each other
  std::vector<std::string> joint_names;  ///< for messages; empty: "joint 1", …
  std::optional<LearnedModel> previous;  ///< model that the held-out looks must improve on (F-C8)
};

struct LookVerdict {
  bool used = true;
  bool second_solution = false;  ///< the other planar pose was taken
  std::string reason;            ///< why not used
  double residual_mm = 0.0, residual_deg = 0.0;
};

struct PoseErrorRms {
  double rms_mm = 0.0, rms_deg = 0.0;
};

struct ArmCalibration {
  LearnedModel model;             ///< revision 0: the controller numbers it
  StateMatrix covariance;         ///< of [v; w; beta], base frame; beta_1 carries its prior
  std::vector<LookVerdict> looks; ///< one a sample, same order
  PoseErrorRms training, heldout; ///< held-out: k-fold over the used looks
  PoseErrorRms previous;          ///< the previous model on the same looks, 0 without one
  int rank = 0, parameters = 0;
  double condition = 0.0;         ///< of the whitened, column-scaled Jacobian without its null space
  std::vector<std::string> unobservable;  ///< sentences
  StateVector null_vector;        ///< of [v; w; beta], largest offset entry -1; zero size when the rank is full
  JointVector beta_sigma_rad;     ///< infinity where not observable
  double camera_sigma_m = 0.0, camera_sigma_rad = 0.0;  ///< norms over the three axes, beta_1 held
  double solve_wall_s = 0.0;
  bool accepted = false;
  std::string why;                ///< one sentence: why refused and what to add, or why accepted
};

/// Never throws on bad data: a set that cannot be solved comes back with accepted = false and the reason.
ArmCalibration calibrate_arm(const ArmModel& arm, const std::vector<LookSample>& looks,
                             const CalibrationOptions& options);

}  // namespace armsight::host
