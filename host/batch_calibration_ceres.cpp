// The same optimum by other people's solver: Ceres over the analytic cost functions of batch_calibration_cost.hpp. What
// the tests and benchmarks hold our own normal equations against.
#include <ceres/gradient_checker.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <memory>

#include "host/batch_calibration_cost.hpp"
#include "host/batch_calibration_refine.hpp"

namespace armsight::host {
namespace {

using Kind = UnknownBlock::Kind;

ceres::LossFunction* make_loss(RobustLoss loss, double width) {
  switch (loss) {
    case RobustLoss::kHuber: return new ceres::HuberLoss(width);
    case RobustLoss::kCauchy: return new ceres::CauchyLoss(width);
    case RobustLoss::kNone: break;
  }
  return nullptr;
}

/// All priors at once, over every block that is not fixed, by the steps from where the problem starts.
class PriorsCost final : public ceres::CostFunction {
 public:
  PriorsCost(const ChainModel& model, const UnknownLayout& layout) : model_(model), layout_(layout) {
    set_num_residuals(prior_rows(model));
    for (const auto& block : layout.blocks) {
      mutable_parameter_block_sizes()->push_back(block.size == 6 ? 7 : block.size);
    }
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    ChainModel model = model_;
    for (std::size_t b = 0; b < layout_.blocks.size(); ++b) load_block(layout_.blocks[b], parameters[b], model);
    Eigen::VectorXd r;
    Eigen::MatrixXd J;
    prior_residuals(model, layout_, r, J);
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    for (std::size_t b = 0; jacobians && b < layout_.blocks.size(); ++b) {
      if (!jacobians[b]) continue;
      const UnknownBlock& block = layout_.blocks[b];
      const Eigen::MatrixXd columns = J.middleCols(block.column, block.size);
      if (block.size != 6) {
        Eigen::Map<RowMajor>(jacobians[b], r.size(), block.size) = columns;
        continue;
      }
      Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
      PoseManifold(block.kind == Kind::kCamera ? StepSide::kRight : StepSide::kLeft)
          .MinusJacobian(parameters[b], lift.data());
      Eigen::Map<RowMajor>(jacobians[b], r.size(), 7) = columns * lift;
    }
    return true;
  }

 private:
  ChainModel model_;
  UnknownLayout layout_;
};

ceres::Manifold* manifold_of(const UnknownBlock& block) {
  if (block.size != 6) return nullptr;
  return new PoseManifold(block.kind == Kind::kCamera ? StepSide::kRight : StepSide::kLeft);
}

}  // namespace

Refined refine_by_ceres(const ChainModel& model, const std::vector<Observation>& observations,
                        const std::vector<char>& used, const BatchOptions& options, double width) {
  const UnknownLayout layout = unknown_layout(model);
  ChainModel scratch = model;
  UnknownValues values(model);
  ceres::Problem problem;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const Observation& z = observations[i];
    auto* cost = new LookCost(scratch, z, LookWeight(model, z, options.noise));
    const double rows_width = width * std::sqrt(static_cast<double>(z.rows()));
    problem.AddResidualBlock(cost, make_loss(options.loss, rows_width), cost->blocks(values));
    for (const auto& block : cost->columns().blocks) {
      if (!layout.find(block.kind, block.index)) problem.SetParameterBlockConstant(values.of(block));
    }
  }
  std::vector<double*> free_blocks;
  for (const auto& block : layout.blocks) {
    free_blocks.push_back(values.of(block));
    problem.AddParameterBlock(values.of(block), block.size == 6 ? 7 : block.size, manifold_of(block));
  }
  if (prior_rows(model) > 0) problem.AddResidualBlock(new PriorsCost(model, layout), nullptr, free_blocks);
  ceres::Solver::Options ceres_options;
  ceres_options.num_threads = 1;  // deterministic
  ceres_options.linear_solver_type = ceres::DENSE_QR;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.function_tolerance = 1e-16;
  ceres_options.gradient_tolerance = 1e-14;
  ceres_options.parameter_tolerance = 1e-14;
  ceres_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem, &summary);
  values.write_to(scratch);
  return {scratch, static_cast<int>(summary.iterations.size()), summary.termination_type == ceres::CONVERGENCE};
}

double jacobian_disagreement(const ChainModel& model, const std::vector<Observation>& observations,
                             const NoiseModel& noise) {
  ChainModel scratch = model;
  UnknownValues values(model);
  double worst = 0.0;
  for (const auto& z : observations) {
    LookCost cost(scratch, z, LookWeight(model, z, noise));
    const auto blocks = cost.blocks(values);
    std::vector<std::unique_ptr<ceres::Manifold>> owned;
    std::vector<const ceres::Manifold*> manifolds;
    for (const auto& block : cost.columns().blocks) {
      owned.emplace_back(manifold_of(block));
      manifolds.push_back(owned.back().get());
    }
    const ceres::GradientChecker checker(&cost, &manifolds, ceres::NumericDiffOptions());
    ceres::GradientChecker::ProbeResults results;
    checker.Probe(blocks.data(), 1e-6, &results);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const double size = std::max(results.local_numeric_jacobians[b].norm(), 1.0);
      worst = std::max(worst, (results.local_jacobians[b] - results.local_numeric_jacobians[b]).norm() / size);
    }
  }
  return worst;
}

}  // namespace armsight::host
