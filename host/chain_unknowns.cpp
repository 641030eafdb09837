// Bookkeeping of the unknowns of host/chain_problem.hpp: who owns which column, how a step is applied, what priors say.
#include <Eigen/LU>

#include "host/chain_problem.hpp"

namespace armsight::host {
namespace {

using Kind = UnknownBlock::Kind;

Pose exp_step(const Vector6& x) { return {so3_exp(x.tail<3>()), x.head<3>()}; }

const ScalarUnknown& scalar_of(const ChainModel& model, const UnknownBlock& block) {
  const auto index = static_cast<std::size_t>(block.index);
  if (block.kind == Kind::kOffset) return model.offsets[index];
  return block.kind == Kind::kScale ? model.targets[index].scale : model.time_offset;
}

Freedom freedom_of(const ChainModel& model, const UnknownBlock& block) {
  const auto index = static_cast<std::size_t>(block.index);
  switch (block.kind) {
    case Kind::kCamera: return model.T_C_a.freedom;
    case Kind::kMount: return model.targets[index].T_b_M.freedom;
    case Kind::kAxis: return model.axes[index].freedom;
    case Kind::kIntrinsics: return model.camera_unknown.freedom;
    default: return scalar_of(model, block).freedom;
  }
}

/// (value − prior) / sigma of one block and its Jacobian by the block's step.
void prior_of(const ChainModel& model, const UnknownBlock& block, Eigen::Ref<Eigen::VectorXd> r,
              Eigen::Ref<Eigen::MatrixXd> J) {
  const auto index = static_cast<std::size_t>(block.index);
  if (block.size == 6) {
    const bool is_camera = block.kind == Kind::kCamera;
    const PoseUnknown& pose = is_camera ? model.T_C_a : model.targets[index].T_b_M;
    Matrix6 rows;
    r = pose_prior_residual(pose, pose.value, is_camera, &rows);
    J = rows;
  } else if (block.kind == Kind::kAxis) {
    const AxisUnknown& axis = model.axes[index];
    Eigen::Vector4d weight;
    weight << Eigen::Vector2d::Constant(1.0 / axis.prior_sigma_m),
        Eigen::Vector2d::Constant(1.0 / axis.prior_sigma_rad);
    r = weight.cwiseProduct(axis.value);
    J = weight.asDiagonal();
  } else if (block.kind == Kind::kIntrinsics) {
    const IntrinsicsVector weight = model.camera_unknown.prior_sigma.cwiseInverse();
    r = weight.cwiseProduct(to_vector(model.camera) - model.camera_unknown.prior);
    J = weight.asDiagonal();
  } else {
    const ScalarUnknown& scalar = scalar_of(model, block);
    r[0] = (scalar.value - scalar.prior) / scalar.prior_sigma;
    J(0, 0) = 1.0 / scalar.prior_sigma;
  }
}

void step(const UnknownBlock& block, const Eigen::VectorXd& x, ChainModel& model) {
  const auto index = static_cast<std::size_t>(block.index);
  const double head = x[block.column];
  switch (block.kind) {
    case Kind::kCamera: model.T_C_a.value = model.T_C_a.value * exp_step(x.segment<6>(block.column)); break;
    case Kind::kMount:
      model.targets[index].T_b_M.value = exp_step(x.segment<6>(block.column)) * model.targets[index].T_b_M.value;
      break;
    case Kind::kOffset: model.offsets[index].value += head; break;
    case Kind::kScale: model.targets[index].scale.value += head; break;
    case Kind::kAxis: model.axes[index].value += x.segment<4>(block.column); break;
    case Kind::kIntrinsics:
      model.camera = with_vector(model.camera, to_vector(model.camera) + x.segment<9>(block.column));
      break;
    case Kind::kTime: model.time_offset.value += head; break;
  }
}

}  // namespace

IntrinsicsVector to_vector(const Intrinsics& c) {
  IntrinsicsVector x;
  x << c.fx, c.fy, c.cx, c.cy, Eigen::Map<const Eigen::Matrix<double, 5, 1>>(c.plumb_bob.data());
  return x;
}

Intrinsics with_vector(const Intrinsics& camera, const IntrinsicsVector& x) {
  Intrinsics c = camera;
  c.fx = x[0];
  c.fy = x[1];
  c.cx = x[2];
  c.cy = x[3];
  Eigen::Map<Eigen::Matrix<double, 5, 1>>(c.plumb_bob.data()) = x.tail<5>();
  return c;
}

Vector6 pose_prior_residual(const PoseUnknown& unknown, const Pose& value, bool steps_right, Matrix6* J) {
  const Vector6 e = pose_error(value, unknown.prior);
  const Matrix3 J_l_inverse = so3_left_jacobian(e.tail<3>()).inverse();
  J->setZero();
  J->block<3, 3>(0, 0) = steps_right ? value.R : Matrix3::Identity();
  if (!steps_right) J->block<3, 3>(0, 3) = -skew(value.p);
  J->block<3, 3>(3, 3) = steps_right ? Matrix3(J_l_inverse * value.R) : J_l_inverse;
  Vector6 weight;
  weight << Vector3::Constant(1.0 / unknown.prior_sigma_m), Vector3::Constant(1.0 / unknown.prior_sigma_rad);
  *J = weight.asDiagonal() * *J;
  return weight.cwiseProduct(e);
}

const UnknownBlock* UnknownLayout::find(Kind kind, int index) const {
  for (const auto& block : blocks) {
    if (block.kind == kind && block.index == index) return &block;
  }
  return nullptr;
}

UnknownLayout unknown_layout(const ChainModel& model) {
  UnknownLayout layout;
  const auto add = [&](Kind kind, std::size_t index, int size) {
    const UnknownBlock block{kind, static_cast<int>(index), layout.columns, size};
    if (freedom_of(model, block) == Freedom::kFixed) return;
    layout.blocks.push_back(block);
    layout.columns += size;
  };
  add(Kind::kCamera, 0, 6);
  for (std::size_t t = 0; t < model.targets.size(); ++t) add(Kind::kMount, t, 6);
  for (std::size_t j = 0; j < model.offsets.size(); ++j) add(Kind::kOffset, j, 1);
  for (std::size_t t = 0; t < model.targets.size(); ++t) add(Kind::kScale, t, 1);
  for (std::size_t j = 0; j < model.axes.size(); ++j) add(Kind::kAxis, j, 4);
  add(Kind::kIntrinsics, 0, 9);
  add(Kind::kTime, 0, 1);
  return layout;
}

ChainModel retract(const ChainModel& model, const UnknownLayout& layout, const Eigen::VectorXd& x) {
  ChainModel moved = model;
  for (const auto& block : layout.blocks) step(block, x, moved);
  return moved;
}

int prior_rows(const ChainModel& model) {
  int rows = 0;
  for (const auto& block : unknown_layout(model).blocks) {
    rows += freedom_of(model, block) == Freedom::kPrior ? block.size : 0;
  }
  return rows;
}

void prior_residuals(const ChainModel& model, const UnknownLayout& layout, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
  const int rows = prior_rows(model);
  r.setZero(rows);
  J.setZero(rows, layout.columns);
  int row = 0;
  for (const auto& block : layout.blocks) {
    if (freedom_of(model, block) != Freedom::kPrior) continue;
    prior_of(model, block, r.segment(row, block.size), J.block(row, block.column, block.size, block.size));
    row += block.size;
  }
}

}  // namespace armsight::host
