#include "host/batch_calibration_cost.hpp"

#include <utility>

namespace armsight::host {
namespace {

template <int Rows, int Cols>
using RowMajor = Eigen::Matrix<double, Rows, Cols, Eigen::RowMajor>;

/// E with dQ = ½ E w: columns 1–3 of the left- (right step) or right-multiplication matrix of Q = (w, x, y, z).
Eigen::Matrix<double, 4, 3> quaternion_step(const double* Q, StepSide side) {
  const double w = Q[0], x = Q[1], y = Q[2], z = Q[3];
  Eigen::Matrix<double, 4, 3> E;
  if (side == StepSide::kRight) {
    E << -x, -y, -z, w, -z, y, z, w, -x, -y, x, w;
  } else {
    E << -x, -y, -z, w, z, -y, -z, w, x, y, -x, w;
  }
  return E;
}

}  // namespace

PoseBlock to_block(const Pose& pose) {
  const Eigen::Quaterniond quat(pose.R);
  return {quat.w(), quat.x(), quat.y(), quat.z(), pose.p.x(), pose.p.y(), pose.p.z()};
}

Pose from_block(const double* block) {
  const Eigen::Quaterniond quat(block[0], block[1], block[2], block[3]);
  return {quat.normalized().toRotationMatrix(), Vector3(block[4], block[5], block[6])};
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Pose step{so3_exp(Vector3(delta[3], delta[4], delta[5])), Vector3(delta[0], delta[1], delta[2])};
  const PoseBlock moved = to_block(side_ == StepSide::kRight ? from_block(x) * step : step * from_block(x));
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor<7, 6>> J(jacobian);
  const Pose pose = from_block(x);
  J.setZero();
  J.block<4, 3>(0, 3) = 0.5 * quaternion_step(x, side_);
  if (side_ == StepSide::kRight) {
    J.block<3, 3>(4, 0) = pose.R;
  } else {
    J.block<3, 3>(4, 0).setIdentity();
    J.block<3, 3>(4, 3) = -skew(pose.p);
  }
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Pose step =
      side_ == StepSide::kRight ? from_block(x).inverse() * from_block(y) : from_block(y) * from_block(x).inverse();
  Eigen::Map<Vector6> delta(y_minus_x);
  delta << step.p, so3_log(step.R);
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor<6, 7>> J(jacobian);
  const Pose pose = from_block(x);
  J.setZero();
  J.block<3, 4>(3, 0) = 2.0 * quaternion_step(x, side_).transpose();  // EᵀE = I on the unit sphere
  if (side_ == StepSide::kRight) {
    J.block<3, 3>(0, 4) = pose.R.transpose();
  } else {
    J.block<3, 3>(0, 4).setIdentity();
    J.block<3, 4>(0, 0) = skew(pose.p) * J.block<3, 4>(3, 0);
  }
  return true;
}

UnknownValues::UnknownValues(const ChainModel& model) : camera(to_block(model.T_C_a.value)) {
  for (const auto& target : model.targets) {
    mounts.push_back(to_block(target.T_b_M.value));
    scales.push_back(target.scale.value);
  }
  for (const auto& offset : model.offsets) offsets.push_back(offset.value);
}

void UnknownValues::write_to(ChainModel& model) const {
  model.T_C_a.value = from_block(camera.data());
  for (std::size_t t = 0; t < mounts.size(); ++t) {
    model.targets[t].T_b_M.value = from_block(mounts[t].data());
    model.targets[t].scale.value = scales[t];
  }
  for (std::size_t j = 0; j < offsets.size(); ++j) model.offsets[j].value = offsets[j];
}

LookCost::LookCost(ChainModel& scratch, const Observation& z, Eigen::MatrixXd W)
    : scratch_(scratch), z_(z), W_(std::move(W)), involved_(involved_joints(scratch, z.target)) {
  set_num_residuals(z.rows());
  mutable_parameter_block_sizes()->assign(2, 7);
  mutable_parameter_block_sizes()->insert(mutable_parameter_block_sizes()->end(), involved_.size() + 1, 1);
}

std::vector<double*> LookCost::blocks(UnknownValues& values) const {
  const auto target = static_cast<std::size_t>(z_.target);
  std::vector<double*> pointers{values.camera.data(), values.mounts[target].data()};
  for (const int joint : involved_) pointers.push_back(&values.offsets[static_cast<std::size_t>(joint)]);
  pointers.push_back(&values.scales[target]);
  return pointers;
}

void LookCost::load(double const* const* parameters) const {
  ProblemTarget& target = scratch_.targets[static_cast<std::size_t>(z_.target)];
  scratch_.T_C_a.value = from_block(parameters[0]);
  target.T_b_M.value = from_block(parameters[1]);
  for (std::size_t k = 0; k < involved_.size(); ++k) {
    scratch_.offsets[static_cast<std::size_t>(involved_[k])].value = parameters[2 + k][0];
  }
  target.scale.value = parameters[2 + involved_.size()][0];
}

bool LookCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  load(parameters);
  Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
  if (!jacobians) {
    const auto plain = residual_only(scratch_, z_);
    if (plain) r = W_ * *plain;
    return plain.has_value();
  }
  const auto residual = residual_of(scratch_, z_, involved_);
  if (!residual) return false;
  r = W_ * residual->r;
  const Eigen::MatrixXd J = W_ * residual->J;
  for (int b = 0; b < 2; ++b) {
    if (!jacobians[b]) continue;
    RowMajor<6, 7> lift;  // tangent → ambient: its product with PlusJacobian is the identity
    PoseManifold(b == 0 ? StepSide::kRight : StepSide::kLeft).MinusJacobian(parameters[b], lift.data());
    Eigen::Map<RowMajor<Eigen::Dynamic, 7>>(jacobians[b], num_residuals(), 7) = J.middleCols<6>(6 * b) * lift;
  }
  for (Eigen::Index k = 12; k < J.cols(); ++k) {
    double* column = jacobians[k - 10];
    if (column) Eigen::Map<Eigen::VectorXd>(column, num_residuals()) = J.col(k);
  }
  return true;
}

bool PosePriorCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Pose value = from_block(parameters[0]);
  Matrix6 J;
  Eigen::Map<Vector6> r(residuals);
  r = pose_prior_residual(unknown_, value, side_ == StepSide::kRight, &J);
  if (jacobians && jacobians[0]) {
    RowMajor<6, 7> lift;
    PoseManifold(side_).MinusJacobian(parameters[0], lift.data());
    Eigen::Map<RowMajor<6, 7>> ambient(jacobians[0]);
    ambient = J * lift;
  }
  return true;
}

bool ScalarPriorCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  residuals[0] = (parameters[0][0] - prior_) / sigma_;
  if (jacobians && jacobians[0]) jacobians[0][0] = 1.0 / sigma_;
  return true;
}

}  // namespace armsight::host
