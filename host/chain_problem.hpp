// The general calibration problem: a camera at the end of one chain sees targets at the ends of others,
//   T_C_M = T_C_a · T_0_a⁻¹ · T_0_b · T_b_M,   T_0_a = Λ_A(q + beta), T_0_b = Λ_B(q + beta),
// with a the frame that carries the camera, b the one that carries the target and 0 the root both chains start from.
// Default arm: a = 0 = B (T_C_a = T_C_B), b = H. Eye-in-hand: a = hand, b = 0. No joints: the hand pose is given.
// Unknowns, each fixed, free or with a prior: T_C_a, every T_b_M, the joint offsets beta, one scale a target
// (true size / stated size of the marker), where each joint's axis truly lies, the camera's intrinsics, and the clock
// offset of the looks. Metres, radians, pixels, seconds.
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

/// Where the axis of a joint truly lies, in the frame its description gives it (z along the axis): shifted along x and
/// y, then tilted by the rotation vector (rx, ry, 0). The four freedoms of a line: a shift along z and a turn about it
/// are the neighbours' and the offset's.
struct AxisUnknown {
  Eigen::Vector4d value = Eigen::Vector4d::Zero();  ///< x, y in m; rx, ry in rad
  Freedom freedom = Freedom::kFixed;
  double prior_sigma_m = 0.0, prior_sigma_rad = 0.0;  ///< about 0; kPrior only
  Pose correction() const { return {so3_exp(Vector3(value[2], value[3], 0.0)), Vector3(value[0], value[1], 0.0)}; }
};

/// fx, fy, cx, cy, k1, k2, p1, p2, k3.
using IntrinsicsVector = Eigen::Matrix<double, 9, 1>;
IntrinsicsVector to_vector(const Intrinsics& camera);
Intrinsics with_vector(const Intrinsics& camera, const IntrinsicsVector& x);

struct IntrinsicsUnknown {
  Freedom freedom = Freedom::kFixed;
  IntrinsicsVector prior = IntrinsicsVector::Zero(), prior_sigma = IntrinsicsVector::Ones();  ///< kPrior only
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
  std::vector<AxisUnknown> axes;       ///< one a joint of the problem; empty: all as described
  IntrinsicsUnknown camera_unknown;
  ScalarUnknown time_offset{"the looks' clock", 0.0, Freedom::kFixed, 0.0, 0.0};  ///< t_arm − t_look, s
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
  double at_offset_s = 0.0;           ///< the clock offset at which q and T_0_given were looked up ...
  Eigen::VectorXd q_rate;             ///< ... and how they move there, rad/s; empty: they stand still
  Vector6 given_rate = Vector6::Zero();  ///< of T_0_given: velocity of its origin and turn rate, in the root
  bool by_half_angle = false;         ///< orientation by the vector part of the error quaternion, (4.5) as printed
  std::string label;                  ///< where it came from: "samples.csv:12"

  bool has_corners() const { return !pixels.empty(); }
  int rows() const { return has_corners() ? 2 * static_cast<int>(pixels.size()) : 6; }
};

/// One contiguous piece of unknowns.
struct UnknownBlock {
  enum class Kind { kCamera, kMount, kOffset, kScale, kAxis, kIntrinsics, kTime } kind;
  int index = 0;   ///< of the target or joint
  int column = 0;  ///< first column
  int size = 0;
};

/// The unknowns that one target's looks can depend on, and their columns in such a look's Jacobian: the poses, the
/// offsets of the joints in between and the scale whether fixed or not, the rest where not fixed.
struct LookUnknowns {
  std::vector<int> joints;           ///< of the problem, rising, each once; their offsets stand from kFirstOffset on
  std::vector<UnknownBlock> blocks;
  int columns = 0;
  int scale = 0, intrinsics = -1, time = -1;  ///< first column; −1: not among them
  std::vector<int> axis;             ///< first column of each joint's axis; empty or −1: not among them
  static constexpr int kFirstOffset = 12;
  int joint_position(int joint) const;  ///< index in `joints`
};
LookUnknowns look_unknowns(const ChainModel& model, int target);

struct PosePrediction {
  Pose T_C_M;              ///< true size
  Eigen::MatrixXd J;       ///< 6 × columns: ∂[p; φ] in C; nothing in the columns of scale and intrinsics
};
PosePrediction predict_T_C_M(const ChainModel& model, const Observation& z, const LookUnknowns& columns);
Pose predicted_T_C_M(const ChainModel& model, const Observation& z);

/// T_0_a⁻¹ T_0_b at the model's offsets.
Pose chain_between(const ChainModel& model, const Observation& z);

struct Residual {
  Eigen::VectorXd r;       ///< m, rad (pose) or px (corners), measured − predicted
  Eigen::MatrixXd J;       ///< ∂r, columns of LookUnknowns
  Eigen::MatrixXd G;       ///< corners: ∂pixels/∂[p; φ] of the target in C
};
/// nullopt where a corner falls behind the camera. Pose: position, then log(R_meas R_predᵀ) (5.17), (5.18 as an angle);
/// by_half_angle: the vector part of Q_meas Q_pred⁻¹ (4.5).
std::optional<Residual> residual_of(const ChainModel& model, const Observation& z, const LookUnknowns& columns);
/// Without the Jacobian.
std::optional<Eigen::VectorXd> residual_only(const ChainModel& model, const Observation& z);

/// The tangent of all unknowns that are not fixed.
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

int prior_rows(const ChainModel& model);
/// r and J (rows × layout.columns) of all priors; blocks in the order of the layout.
void prior_residuals(const ChainModel& model, const UnknownLayout& layout, Eigen::VectorXd& r, Eigen::MatrixXd& J);

}  // namespace armsight::host
