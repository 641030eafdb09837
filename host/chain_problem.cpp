#include "host/chain_problem.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

namespace armsight::host {
namespace {

struct ChainEnd {
  Pose T_0_e;
  Jacobian J;  // of the end's origin, in 0; no columns where nothing turns
};

JointVector chain_angles(const ChainModel& model, const ProblemChain& chain, const Observation& z) {
  JointVector q(chain.chain.joint_count);
  for (int i = 0; i < q.size(); ++i) {
    const int joint = chain.joints[static_cast<std::size_t>(i)];
    q[i] = z.q[joint] + model.offsets[static_cast<std::size_t>(joint)].value;  // (4.3)
  }
  return q;
}

Pose end_pose(const ChainModel& model, int chain_index, const Observation& z) {
  if (chain_index == kRoot) return {};
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (chain.is_given) return z.T_0_given;
  return forward_kinematics(chain.chain, chain_angles(model, chain, z));
}

ChainEnd end_kinematics(const ChainModel& model, int chain_index, const Observation& z) {
  ChainEnd end{end_pose(model, chain_index, z), Jacobian(6, 0)};
  if (chain_index == kRoot) return end;
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (!chain.is_given) end.J = hand_kinematics(chain.chain, chain_angles(model, chain, z)).J;
  return end;
}

void add_joints(const ChainModel& model, int chain_index, std::vector<int>& joints) {
  if (chain_index == kRoot) return;
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (!chain.is_given) joints.insert(joints.end(), chain.joints.begin(), chain.joints.end());
}

/// Adds sign · (motion of a point at p_0, carried by the chain's end) to the beta columns, turned into C.
void add_offset_columns(const ChainModel& model, int chain_index, const ChainEnd& end, double sign,
                        const Vector3& p_0, const Matrix3& R_C_0, const std::vector<int>& involved,
                        Eigen::MatrixXd& J) {
  if (end.J.cols() == 0) return;
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  for (int i = 0; i < end.J.cols(); ++i) {
    const auto where = std::lower_bound(involved.begin(), involved.end(), chain.joints[static_cast<std::size_t>(i)]);
    const auto column = 12 + std::distance(involved.begin(), where);
    const Vector3 axis = end.J.col(i).tail<3>();
    const Vector3 velocity = end.J.col(i).head<3>() + axis.cross(p_0 - end.T_0_e.p);
    J.block<3, 1>(0, column) += sign * (R_C_0 * velocity);
    J.block<3, 1>(3, column) += sign * (R_C_0 * axis);
  }
}

Vector6 pose_residual(const Pose& measured, const Pose& predicted, double scale) {
  return pose_error(measured, {predicted.R, predicted.p / scale});  // a marker stated too small looks too near
}

Residual pose_residual_with_jacobian(const Observation& z, const PosePrediction& prediction, double scale) {
  Residual residual;
  residual.r = pose_residual(z.T_C_M, prediction.T_C_M, scale);
  const auto columns = prediction.J.cols();
  residual.J.resize(6, columns + 1);
  residual.J.topLeftCorner(3, columns) = -prediction.J.topRows<3>() / scale;
  const Vector3 e_O = residual.r.tail<3>();
  const Matrix3 J_r_inverse = so3_left_jacobian(-e_O).inverse();  // log(E exp(−φ)) = e − J_r⁻¹ φ
  residual.J.bottomLeftCorner(3, columns) = -J_r_inverse * prediction.J.bottomRows<3>();
  residual.J.rightCols<1>() << prediction.T_C_M.p / (scale * scale), Vector3::Zero();
  return residual;
}

std::optional<Residual> corner_residual_with_jacobian(const Intrinsics& camera, const Observation& z,
                                                      const PosePrediction& prediction, double scale) {
  Residual residual;
  const auto columns = prediction.J.cols();
  residual.r.resize(z.rows());
  residual.J.resize(z.rows(), columns + 1);
  for (std::size_t k = 0; k < z.pixels.size(); ++k) {
    const Vector3 arm = prediction.T_C_M.R * z.points_M[k];
    const auto point = project_with_jacobian(camera, prediction.T_C_M.p + scale * arm);
    if (!point) return std::nullopt;
    const auto row = static_cast<Eigen::Index>(2 * k);
    residual.r.segment<2>(row) = z.pixels[k] - point->pixel;
    residual.J.block(row, 0, 2, columns) =
        -point->J * (prediction.J.topRows<3>() - skew(scale * arm) * prediction.J.bottomRows<3>());
    residual.J.block<2, 1>(row, columns) = -point->J * arm;
  }
  return residual;
}

}  // namespace

std::vector<int> involved_joints(const ChainModel& model, int target) {
  std::vector<int> joints;
  add_joints(model, model.camera_chain, joints);
  add_joints(model, model.targets[static_cast<std::size_t>(target)].chain, joints);
  std::sort(joints.begin(), joints.end());
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
  return joints;
}

Pose chain_between(const ChainModel& model, const Observation& z) {
  const ProblemTarget& target = model.targets[static_cast<std::size_t>(z.target)];
  return end_pose(model, model.camera_chain, z).inverse() * end_pose(model, target.chain, z);
}

Pose predicted_T_C_M(const ChainModel& model, const Observation& z) {
  return model.T_C_a.value * chain_between(model, z) * model.targets[static_cast<std::size_t>(z.target)].T_b_M.value;
}

PosePrediction predict_T_C_M(const ChainModel& model, const Observation& z, const std::vector<int>& involved) {
  const ProblemTarget& target = model.targets[static_cast<std::size_t>(z.target)];
  const ChainEnd a = end_kinematics(model, model.camera_chain, z);
  const ChainEnd b = end_kinematics(model, target.chain, z);
  const Pose T_C_0 = model.T_C_a.value * a.T_0_e.inverse();
  const Pose T_0_M = b.T_0_e * target.T_b_M.value;
  const Pose T_C_b = T_C_0 * b.T_0_e;

  PosePrediction prediction;
  prediction.T_C_M = T_C_0 * T_0_M;
  Eigen::MatrixXd& J = prediction.J;
  J.setZero(6, 12 + static_cast<Eigen::Index>(involved.size()));
  const Matrix3& R_C_a = model.T_C_a.value.R;
  const Vector3 p_a = a.T_0_e.inverse() * T_0_M.p;  // the target, in a
  J.block<3, 3>(0, 0) = R_C_a;
  J.block<3, 3>(0, 3) = -R_C_a * skew(p_a);
  J.block<3, 3>(3, 3) = R_C_a;
  J.block<3, 3>(0, 6) = T_C_b.R;
  J.block<3, 3>(0, 9) = -T_C_b.R * skew(target.T_b_M.value.p);
  J.block<3, 3>(3, 9) = T_C_b.R;
  add_offset_columns(model, target.chain, b, 1.0, T_0_M.p, T_C_0.R, involved, J);
  add_offset_columns(model, model.camera_chain, a, -1.0, T_0_M.p, T_C_0.R, involved, J);  // it turns the camera away
  return prediction;
}

std::optional<Residual> residual_of(const ChainModel& model, const Observation& z, const std::vector<int>& involved) {
  const PosePrediction prediction = predict_T_C_M(model, z, involved);
  const double scale = model.targets[static_cast<std::size_t>(z.target)].scale.value;
  if (z.has_corners()) return corner_residual_with_jacobian(model.camera, z, prediction, scale);
  return pose_residual_with_jacobian(z, prediction, scale);
}

std::optional<Eigen::VectorXd> residual_only(const ChainModel& model, const Observation& z) {
  const Pose T_C_M = predicted_T_C_M(model, z);
  const double scale = model.targets[static_cast<std::size_t>(z.target)].scale.value;
  if (!z.has_corners()) return pose_residual(z.T_C_M, T_C_M, scale);
  Eigen::VectorXd r(z.rows());
  for (std::size_t k = 0; k < z.pixels.size(); ++k) {
    const auto point = project_with_jacobian(model.camera, T_C_M * Vector3(scale * z.points_M[k]));
    if (!point) return std::nullopt;
    r.segment<2>(static_cast<Eigen::Index>(2 * k)) = z.pixels[k] - point->pixel;
  }
  return r;
}

Eigen::MatrixXd square_root_information(const ChainModel& model, const Observation& z, const NoiseModel& noise) {
  if (z.has_corners()) return Eigen::MatrixXd::Identity(z.rows(), z.rows()) / z.sigma_px;
  const PosePrediction prediction = predict_T_C_M(model, z, involved_joints(model, z.target));
  const Matrix6 R = look_covariance(z.R_vision, prediction.J.rightCols(prediction.J.cols() - 12), noise);
  const Matrix6 L = R.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(Matrix6::Identity());
}

}  // namespace armsight::host
