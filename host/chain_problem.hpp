// The general calibration problem: a camera at the end of one chain sees targets at the ends of others,
//   T_C_M = T_C_a · T_0_a⁻¹ · T_0_b · T_b_M,   T_0_a = Λ_A(q + beta), T_0_b = Λ_B(q + beta),
// with a the frame that carries the camera, b the one that carries the target and 0 the root both chains start from.
// Default arm: a = 0 = B (T_C_a = T_C_B), b = H. Eye-in-hand: a = hand, b = 0. No joints: the hand pose is given.
// Unknowns, each fixed, free or with a prior: T_C_a, every T_b_M, the joint offsets beta, one scale a target
// (true size / stated size of the marker). Metres, radians, pixels.
//
// Tangent of the poses: T_C_a ← T_C_a [exp(S(w)), v; 0, 1] and T_b_M ← [exp(S(w)), v; 0, 1] T_b_M, so both errors live
// in the frame of the chain's end: there the null directions are constant (specification §5.1, §5.3).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/pinhole_projection.hpp"
#include "shared/hand_eye.hpp"

namespace armsight::host {

enum class Freedom { kFixed, kFree, kPrior };

struct PoseUnknown {
  std::string name;  ///< for people: "the camera on head", "the mount of left_gripper"
  Pose value;
  Freedom freedom = Freedom::kFree;
  Pose prior;
  double prior_sigma_m = 0.0, prior_sigma_rad = 0.0;  ///< kPrior only
};

struct ScalarUnknown {
  std::string name;
  double value = 0.0;
  Freedom freedom = Freedom::kFixed;
  double prior = 0.0, prior_sigma = 0.0;  ///< kPrior only
};

inline constexpr int kRoot = -1;  ///< in place of a chain's index: fixed to the root

struct ProblemChain {
  std::string name;
  SerialChain chain;
  std::vector<int> joints;  ///< joint i of the chain is joint joints[i] of the problem
  bool is_given = false;    ///< no joints: its tip comes with every observation
};

struct ProblemTarget {
  std::string name;
  int chain = kRoot;
  PoseUnknown T_b_M;
  ScalarUnknown scale{"", 1.0, Freedom::kFixed, 1.0, 0.0};
};

struct ChainModel {
  std::vector<ProblemChain> chains;
  std::vector<ScalarUnknown> offsets;  ///< beta, one a joint of the problem
  int camera_chain = kRoot;
  PoseUnknown T_C_a;
  std::vector<ProblemTarget> targets;
  Intrinsics camera;                   ///< needed where corners are observed
};

struct Observation {
  int target = 0;
  Eigen::VectorXd q;                  ///< reading of every joint of the problem, rad
  Pose T_0_given;                     ///< tip of the given chain
  Pose T_C_M;                         ///< measured pose (with corners: a start, from PnP)
  std::optional<Pose> T_C_M_second;   ///< the other planar solution
  Matrix6 R_vision = Matrix6::Zero(); ///< covariance of T_C_M, in C, position then rotation
  std::vector<Vector3> points_M;      ///< corners on the target, stated size ...
  std::vector<Eigen::Vector2d> pixels;  ///< ... and where they were seen; empty: the pose is the observation
  double sigma_px = 1.0;
  std::string label;                  ///< where it came from: "samples.csv:12"

  bool has_corners() const { return !pixels.empty(); }
  int rows() const { return has_corners() ? 2 * static_cast<int>(pixels.size()) : 6; }
};

/// Problem joints that move what this target's observations show, rising, each once.
std::vector<int> involved_joints(const ChainModel& model, int target);

struct PosePrediction {
  Pose T_C_M;              ///< true size
  Eigen::MatrixXd J;       ///< 6 × (6 + 6 + involved): ∂[p; φ] in C by T_C_a, T_b_M, beta
};
PosePrediction predict_T_C_M(const ChainModel& model, const Observation& z, const std::vector<int>& involved);
Pose predicted_T_C_M(const ChainModel& model, const Observation& z);

/// T_0_a⁻¹ T_0_b at the model's offsets.
Pose chain_between(const ChainModel& model, const Observation& z);

struct Residual {
  Eigen::VectorXd r;       ///< m, rad (pose) or px (corners), measured − predicted
  Eigen::MatrixXd J;       ///< ∂r by T_C_a (6), T_b_M (6), beta (involved), scale (1)
};
/// nullopt where a corner falls behind the camera. Position, then log(R_meas R_predᵀ) (5.17), (5.18 as an angle).
std::optional<Residual> residual_of(const ChainModel& model, const Observation& z, const std::vector<int>& involved);
/// Without the Jacobian.
std::optional<Eigen::VectorXd> residual_only(const ChainModel& model, const Observation& z);

/// W with ‖W r‖² = rᵀ R⁻¹ r, R = look_covariance; corners: I / sigma_px, whatever the noise model.
Eigen::MatrixXd square_root_information(const ChainModel& model, const Observation& z, const NoiseModel& noise);

/// One contiguous piece of the tangent of all unknowns that are not fixed.
struct UnknownBlock {
  enum class Kind { kCamera, kMount, kOffset, kScale } kind;
  int index = 0;   ///< of the target or joint
  int column = 0;  ///< first column
  int size = 0;
};
struct UnknownLayout {
  std::vector<UnknownBlock> blocks;
  int columns = 0;
  const UnknownBlock* find(UnknownBlock::Kind kind, int index) const;
};
UnknownLayout unknown_layout(const ChainModel& model);
/// model ⊞ x.
ChainModel retract(const ChainModel& model, const UnknownLayout& layout, const Eigen::VectorXd& x);

/// (value − prior) / sigma, position then log(R R_priorᵀ); J by the pose's own tangent (right: T_C_a, left: T_b_M).
Vector6 pose_prior_residual(const PoseUnknown& unknown, const Pose& value, bool steps_right, Matrix6* J);

/// Whitened Jacobian of the observations marked used, then of the priors: rows × layout.columns.
Eigen::MatrixXd whitened_jacobian(const ChainModel& model, const std::vector<Observation>& observations,
                                  const std::vector<char>& used, const NoiseModel& noise,
                                  const UnknownLayout& layout, bool with_priors);

}  // namespace armsight::host
