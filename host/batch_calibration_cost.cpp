#include "host/batch_calibration_cost.hpp"

#include <utility>

namespace armsight::host {
namespace {

template <int Rows, int Cols>
using RowMajor = Eigen::Matrix<double, Rows, Cols, Eigen::RowMajor>;
/// As Ceres lays a Jacobian out; a column stays a column.
using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Kind = UnknownBlock::Kind;

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

UnknownValues::UnknownValues(const ChainModel& model) {
  const auto put = [this](Kind kind, std::size_t index, const double* numbers, std::size_t count) {
    values_[{kind, static_cast<int>(index)}].assign(numbers, numbers + count);
  };
  put(Kind::kCamera, 0, to_block(model.T_C_a.value).data(), 7);
  for (std::size_t t = 0; t < model.targets.size(); ++t) {
    put(Kind::kMount, t, to_block(model.targets[t].T_b_M.value).data(), 7);
    put(Kind::kScale, t, &model.targets[t].scale.value, 1);
  }
  for (std::size_t j = 0; j < model.offsets.size(); ++j) put(Kind::kOffset, j, &model.offsets[j].value, 1);
  for (std::size_t j = 0; j < model.axes.size(); ++j) put(Kind::kAxis, j, model.axes[j].value.data(), 4);
  put(Kind::kIntrinsics, 0, to_vector(model.camera).data(), 9);
  put(Kind::kTime, 0, &model.time_offset.value, 1);
}

void UnknownValues::write_to(ChainModel& model) const {
  for (const auto& [key, numbers] : values_) load_block({key.first, key.second, 0, 0}, numbers.data(), model);
}

void load_block(const UnknownBlock& block, const double* values, ChainModel& model) {
  const auto index = static_cast<std::size_t>(block.index);
  switch (block.kind) {
    case Kind::kCamera: model.T_C_a.value = from_block(values); break;
    case Kind::kMount: model.targets[index].T_b_M.value = from_block(values); break;
    case Kind::kOffset: model.offsets[index].value = *values; break;
    case Kind::kScale: model.targets[index].scale.value = *values; break;
    case Kind::kAxis: model.axes[index].value = Eigen::Map<const Eigen::Vector4d>(values); break;
    case Kind::kIntrinsics:
      model.camera = with_vector(model.camera, Eigen::Map<const IntrinsicsVector>(values));
      break;
    case Kind::kTime: model.time_offset.value = *values; break;
  }
}

LookCost::LookCost(ChainModel& scratch, const Observation& z, LookWeight W)
    : scratch_(scratch), z_(z), W_(std::move(W)), columns_(look_unknowns(scratch, z.target)) {
  set_num_residuals(z.rows());
  for (const auto& block : columns_.blocks) {
    mutable_parameter_block_sizes()->push_back(block.size == 6 ? 7 : block.size);
  }
}

std::vector<double*> LookCost::blocks(UnknownValues& values) const {
  std::vector<double*> pointers;
  for (const auto& block : columns_.blocks) pointers.push_back(values.of(block));
  return pointers;
}

bool LookCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  for (std::size_t b = 0; b < columns_.blocks.size(); ++b) load_block(columns_.blocks[b], parameters[b], scratch_);
  Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
  if (!jacobians) {
    const auto plain = residual_only(scratch_, z_);
    if (plain) r = W_ * *plain;
    return plain.has_value();
  }
  const auto residual = residual_of(scratch_, z_, columns_);
  if (!residual) return false;
  r = W_ * residual->r;
  const Eigen::MatrixXd J = W_ * residual->J;
  for (std::size_t b = 0; b < columns_.blocks.size(); ++b) {
    if (!jacobians[b]) continue;
    const UnknownBlock& block = columns_.blocks[b];
    if (block.size != 6) {
      Eigen::Map<RowMajorX>(jacobians[b], num_residuals(), block.size) = J.middleCols(block.column, block.size);
      continue;
    }
    RowMajor<6, 7> lift;  // tangent → ambient: its product with PlusJacobian is the identity
    PoseManifold(block.kind == Kind::kCamera ? StepSide::kRight : StepSide::kLeft)
        .MinusJacobian(parameters[b], lift.data());
    Eigen::Map<RowMajorX>(jacobians[b], num_residuals(), 7) = J.middleCols<6>(block.column) * lift;
  }
  return true;
}

}  // namespace armsight::host
