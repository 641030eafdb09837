#include "host/chain_problem.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "host/chain_kinematics.hpp"

namespace armsight::host {
namespace {

void add_joints(const ChainModel& model, int chain_index, std::vector<int>& joints) {
  if (chain_index == kRoot) return;
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (!chain.is_given) joints.insert(joints.end(), chain.joints.begin(), chain.joints.end());
}

double scale_of(const ChainModel& model, const Observation& z) {
  return model.targets[static_cast<std::size_t>(z.target)].scale.value;
}

/// Q_meas Q_pred⁻¹ with η ≥ 0.
Eigen::Quaterniond error_quaternion(const Matrix3& measured, const Matrix3& predicted) {
  Eigen::Quaterniond quat(Matrix3(measured * predicted.transpose()));
  if (quat.w() < 0.0) quat.coeffs() = -quat.coeffs();
  return quat;
}

Vector6 pose_residual(const Observation& z, const Pose& predicted, double scale) {
  // a marker stated too small looks too near
  if (!z.by_half_angle) return pose_error(z.T_C_M, {predicted.R, predicted.p / scale});
  Vector6 e;
  e << z.T_C_M.p - predicted.p / scale, error_quaternion(z.T_C_M.R, predicted.R).vec();
  return e;
}

/// ∂(orientation error)/∂φ of the prediction.
Matrix3 orientation_slope(const Observation& z, const Pose& predicted, const Vector3& e_O) {
  if (!z.by_half_angle) return -so3_left_jacobian(-e_O).inverse();  // log(E exp(−φ)) = e − J_r⁻¹ φ
  const double eta = error_quaternion(z.T_C_M.R, predicted.R).w();
  return -0.5 * (eta * Matrix3::Identity() + skew(e_O));  // B of specification §5.2
}

Residual pose_residual_with_jacobian(const Observation& z, const PosePrediction& prediction, double scale,
                                     const LookUnknowns& columns) {
  Residual residual;
  residual.r = pose_residual(z, prediction.T_C_M, scale);
  residual.J.resize(6, columns.columns);
  residual.J.topRows<3>().noalias() = prediction.J.topRows<3>() * (-1.0 / scale);
  const Matrix3 slope = orientation_slope(z, prediction.T_C_M, residual.r.tail<3>());
  residual.J.bottomRows<3>().noalias() = slope * prediction.J.bottomRows<3>();
  residual.J.col(columns.scale) << prediction.T_C_M.p / (scale * scale), Vector3::Zero();
  return residual;
}

std::optional<Residual> corner_residual_with_jacobian(const Intrinsics& camera, const Observation& z,
                                                      const PosePrediction& prediction, double scale,
                                                      const LookUnknowns& columns) {
  Residual residual;
  residual.r.resize(z.rows());
  residual.G.resize(z.rows(), 6);
  Eigen::MatrixXd intrinsics(z.rows(), 9);
  Eigen::VectorXd by_scale(z.rows());
  for (std::size_t k = 0; k < z.pixels.size(); ++k) {
    const Vector3 arm = prediction.T_C_M.R * z.points_M[k];
    const auto point = project_with_jacobian(camera, prediction.T_C_M.p + scale * arm);
    if (!point) return std::nullopt;
    const auto row = static_cast<Eigen::Index>(2 * k);
    residual.r.segment<2>(row) = z.pixels[k] - point->pixel;
    residual.G.block<2, 3>(row, 0) = point->J;
    residual.G.block<2, 3>(row, 3) = -point->J * skew(scale * arm);
    by_scale.segment<2>(row) = -point->J * arm;
    if (columns.intrinsics >= 0) intrinsics.middleRows<2>(row) = -point->J_intrinsics;
  }
  residual.J.noalias() = -residual.G * prediction.J;
  residual.J.col(columns.scale) = by_scale;
  if (columns.intrinsics >= 0) residual.J.middleCols<9>(columns.intrinsics) = intrinsics;
  return residual;
}

}  // namespace

int LookUnknowns::joint_position(int joint) const {
  return static_cast<int>(std::lower_bound(joints.begin(), joints.end(), joint) - joints.begin());
}

LookUnknowns look_unknowns(const ChainModel& model, int target) {
  using Kind = UnknownBlock::Kind;
  LookUnknowns look;
  add_joints(model, model.camera_chain, look.joints);
  add_joints(model, model.targets[static_cast<std::size_t>(target)].chain, look.joints);
  std::sort(look.joints.begin(), look.joints.end());
  look.joints.erase(std::unique(look.joints.begin(), look.joints.end()), look.joints.end());
  const auto add = [&look](Kind kind, int index, int size) {
    look.blocks.push_back({kind, index, look.columns, size});
    look.columns += size;
    return look.columns - size;
  };
  add(Kind::kCamera, 0, 6);
  add(Kind::kMount, target, 6);
  for (const int joint : look.joints) add(Kind::kOffset, joint, 1);
  look.scale = add(Kind::kScale, target, 1);
  if (!model.axes.empty()) {
    for (const int joint : look.joints) {
      const bool is_free = model.axes[static_cast<std::size_t>(joint)].freedom != Freedom::kFixed;
      look.axis.push_back(is_free ? add(Kind::kAxis, joint, 4) : -1);
    }
  }
  if (model.camera_unknown.freedom != Freedom::kFixed) look.intrinsics = add(Kind::kIntrinsics, 0, 9);
  if (model.time_offset.freedom != Freedom::kFixed) look.time = add(Kind::kTime, 0, 1);
  return look;
}

Pose chain_between(const ChainModel& model, const Observation& z) {
  const ProblemTarget& target = model.targets[static_cast<std::size_t>(z.target)];
  return end_pose(model, model.camera_chain, z).inverse() * end_pose(model, target.chain, z);
}

Pose predicted_T_C_M(const ChainModel& model, const Observation& z) {
  return model.T_C_a.value * chain_between(model, z) * model.targets[static_cast<std::size_t>(z.target)].T_b_M.value;
}

PosePrediction predict_T_C_M(const ChainModel& model, const Observation& z, const LookUnknowns& columns) {
  const ProblemTarget& target = model.targets[static_cast<std::size_t>(z.target)];
  const ChainMotion a = end_motion(model, model.camera_chain, z);
  const ChainMotion b = end_motion(model, target.chain, z);
  const Pose T_C_0 = model.T_C_a.value * a.T_0_e.inverse();
  const Pose T_0_M = b.T_0_e * target.T_b_M.value;
  const Pose T_C_b = T_C_0 * b.T_0_e;

  PosePrediction prediction;
  prediction.T_C_M = T_C_0 * T_0_M;
  Eigen::MatrixXd& J = prediction.J;
  J.setZero(6, columns.columns);
  const Matrix3& R_C_a = model.T_C_a.value.R;
  const Vector3 p_a = a.T_0_e.inverse() * T_0_M.p;  // the target, in a
  J.block<3, 3>(0, 0) = R_C_a;
  J.block<3, 3>(0, 3) = -R_C_a * skew(p_a);
  J.block<3, 3>(3, 3) = R_C_a;
  J.block<3, 3>(0, 6) = T_C_b.R;
  J.block<3, 3>(0, 9) = -T_C_b.R * skew(target.T_b_M.value.p);
  J.block<3, 3>(3, 9) = T_C_b.R;
  add_motion_columns(model, target.chain, z, b, 1.0, T_0_M.p, T_C_0.R, columns, J);
  add_motion_columns(model, model.camera_chain, z, a, -1.0, T_0_M.p, T_C_0.R, columns, J);  // it turns the camera away
  return prediction;
}

std::optional<Residual> residual_of(const ChainModel& model, const Observation& z, const LookUnknowns& columns) {
  const PosePrediction prediction = predict_T_C_M(model, z, columns);
  if (z.has_corners()) {
    return corner_residual_with_jacobian(model.camera, z, prediction, scale_of(model, z), columns);
  }
  return pose_residual_with_jacobian(z, prediction, scale_of(model, z), columns);
}

std::optional<Eigen::VectorXd> residual_only(const ChainModel& model, const Observation& z) {
  const Pose T_C_M = predicted_T_C_M(model, z);
  const double scale = scale_of(model, z);
  if (!z.has_corners()) return pose_residual(z, T_C_M, scale);
  Eigen::VectorXd r(z.rows());
  for (std::size_t k = 0; k < z.pixels.size(); ++k) {
    const auto point = project_with_jacobian(model.camera, T_C_M * Vector3(scale * z.points_M[k]));
    if (!point) return std::nullopt;
    r.segment<2>(static_cast<Eigen::Index>(2 * k)) = z.pixels[k] - point->pixel;
  }
  return r;
}

}  // namespace armsight::host
