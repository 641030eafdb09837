// Bookkeeping of the unknowns of host/chain_problem.hpp: who owns which column, how a step is applied.
#include <Eigen/LU>

#include "host/chain_problem.hpp"

namespace armsight::host {
namespace {

using Kind = UnknownBlock::Kind;

Pose exp_step(const Vector6& x) { return {so3_exp(x.tail<3>()), x.head<3>()}; }

int prior_rows(const ChainModel& model) {
  int rows = model.T_C_a.freedom == Freedom::kPrior ? 6 : 0;
  for (const auto& target : model.targets) {
    rows += target.T_b_M.freedom == Freedom::kPrior ? 6 : 0;
    rows += target.scale.freedom == Freedom::kPrior ? 1 : 0;
  }
  for (const auto& offset : model.offsets) rows += offset.freedom == Freedom::kPrior ? 1 : 0;
  return rows;
}

void add_priors(const ChainModel& model, const UnknownLayout& layout, Eigen::MatrixXd& J, Eigen::Index row) {
  for (const auto& block : layout.blocks) {
    const auto index = static_cast<std::size_t>(block.index);
    if (block.size == 6) {
      const bool is_camera = block.kind == Kind::kCamera;
      const PoseUnknown& pose = is_camera ? model.T_C_a : model.targets[index].T_b_M;
      if (pose.freedom != Freedom::kPrior) continue;
      Matrix6 rows;
      pose_prior_residual(pose, pose.value, is_camera, &rows);
      J.block<6, 6>(row, block.column) = rows;
      row += 6;
    } else {
      const ScalarUnknown& scalar = block.kind == Kind::kOffset ? model.offsets[index] : model.targets[index].scale;
      if (scalar.freedom == Freedom::kPrior) J(row++, block.column) = 1.0 / scalar.prior_sigma;
    }
  }
}

void place(const UnknownBlock* block, const Eigen::MatrixXd& columns, Eigen::Index from, Eigen::MatrixXd& J,
           Eigen::Index row) {
  if (block) J.block(row, block->column, columns.rows(), block->size) = columns.middleCols(from, block->size);
}

}  // namespace

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
  const auto add = [&layout](Kind kind, std::size_t index, int size, Freedom freedom) {
    if (freedom == Freedom::kFixed) return;
    layout.blocks.push_back({kind, static_cast<int>(index), layout.columns, size});
    layout.columns += size;
  };
  add(Kind::kCamera, 0, 6, model.T_C_a.freedom);
  for (std::size_t t = 0; t < model.targets.size(); ++t) add(Kind::kMount, t, 6, model.targets[t].T_b_M.freedom);
  for (std::size_t j = 0; j < model.offsets.size(); ++j) add(Kind::kOffset, j, 1, model.offsets[j].freedom);
  for (std::size_t t = 0; t < model.targets.size(); ++t) add(Kind::kScale, t, 1, model.targets[t].scale.freedom);
  return layout;
}

ChainModel retract(const ChainModel& model, const UnknownLayout& layout, const Eigen::VectorXd& x) {
  ChainModel moved = model;
  for (const auto& block : layout.blocks) {
    const auto index = static_cast<std::size_t>(block.index);
    const double head = x[block.column];
    switch (block.kind) {
      case Kind::kCamera: moved.T_C_a.value = model.T_C_a.value * exp_step(x.segment<6>(block.column)); break;
      case Kind::kMount:
        moved.targets[index].T_b_M.value = exp_step(x.segment<6>(block.column)) * model.targets[index].T_b_M.value;
        break;
      case Kind::kOffset: moved.offsets[index].value += head; break;
      case Kind::kScale: moved.targets[index].scale.value += head; break;
    }
  }
  return moved;
}

Eigen::MatrixXd whitened_jacobian(const ChainModel& model, const std::vector<Observation>& observations,
                                  const std::vector<char>& used, const NoiseModel& noise,
                                  const UnknownLayout& layout, bool with_priors) {
  Eigen::Index rows = with_priors ? prior_rows(model) : 0;
  for (std::size_t i = 0; i < observations.size(); ++i) rows += used[i] ? observations[i].rows() : 0;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, layout.columns);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const Observation& z = observations[i];
    const std::vector<int> involved = involved_joints(model, z.target);
    const auto residual = residual_of(model, z, involved);
    if (residual) {
      const Eigen::MatrixXd columns = square_root_information(model, z, noise) * residual->J;
      place(layout.find(Kind::kCamera, 0), columns, 0, J, row);
      place(layout.find(Kind::kMount, z.target), columns, 6, J, row);
      for (std::size_t k = 0; k < involved.size(); ++k) {
        place(layout.find(Kind::kOffset, involved[k]), columns, static_cast<Eigen::Index>(12 + k), J, row);
      }
      place(layout.find(Kind::kScale, z.target), columns, columns.cols() - 1, J, row);
    }
    row += z.rows();
  }
  if (with_priors) add_priors(model, layout, J, row);
  return J;
}

}  // namespace armsight::host
