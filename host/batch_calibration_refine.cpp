#include "host/batch_calibration_refine.hpp"

#include <ceres/gradient_checker.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/batch_calibration_cost.hpp"

namespace armsight::host {
namespace {

std::unique_ptr<ceres::LossFunction> make_loss(RobustLoss loss, double width) {
  switch (loss) {
    case RobustLoss::kHuber: return std::make_unique<ceres::HuberLoss>(width);
    case RobustLoss::kCauchy: return std::make_unique<ceres::CauchyLoss>(width);
    case RobustLoss::kNone: break;
  }
  return nullptr;
}

/// Owns what one Ceres solve needs; `values` must outlive the problem.
class Refinement {
 public:
  Refinement(const ChainModel& model, const std::vector<Observation>& observations, const std::vector<char>& used,
             const BatchOptions& options, double width)
      : scratch_(model), values_(model), problem_(unowned_manifolds()) {
    add_unknowns(model);
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (!used[i]) continue;
      const Observation& z = observations[i];
      auto* cost = new LookCost(scratch_, z, square_root_information(model, z, options.noise));
      const double rows_width = width * std::sqrt(static_cast<double>(z.rows()));
      problem_.AddResidualBlock(cost, make_loss(options.loss, rows_width).release(), cost->blocks(values_));
    }
    add_priors(model);
  }

  ceres::Solver::Summary solve(int max_iterations) {
    ceres::Solver::Options options;
    options.num_threads = 1;  // deterministic
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;  // few unknowns, many rows; columns are scaled
    options.max_num_iterations = max_iterations;
    options.function_tolerance = 1e-10;
    options.gradient_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary;
  }
  ChainModel result() {
    values_.write_to(scratch_);
    return scratch_;
  }

 private:
  static ceres::Problem::Options unowned_manifolds() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }
  void add_block(double* block, int size, Freedom freedom, ceres::Manifold* manifold) {
    problem_.AddParameterBlock(block, size, manifold);
    if (freedom == Freedom::kFixed) problem_.SetParameterBlockConstant(block);
  }
  void add_unknowns(const ChainModel& model) {
    add_block(values_.camera.data(), 7, model.T_C_a.freedom, &right_);
    for (std::size_t t = 0; t < model.targets.size(); ++t) {
      add_block(values_.mounts[t].data(), 7, model.targets[t].T_b_M.freedom, &left_);
      add_block(&values_.scales[t], 1, model.targets[t].scale.freedom, nullptr);
    }
    for (std::size_t j = 0; j < model.offsets.size(); ++j) {
      add_block(&values_.offsets[j], 1, model.offsets[j].freedom, nullptr);
    }
  }
  void add_pose_prior(const PoseUnknown& pose, StepSide side, double* block) {
    if (pose.freedom != Freedom::kPrior) return;
    problem_.AddResidualBlock(new PosePriorCost(pose, side), nullptr, block);
  }
  void add_scalar_prior(const ScalarUnknown& scalar, double* block) {
    if (scalar.freedom != Freedom::kPrior) return;
    problem_.AddResidualBlock(new ScalarPriorCost(scalar.prior, scalar.prior_sigma), nullptr, block);
  }
  void add_priors(const ChainModel& model) {
    add_pose_prior(model.T_C_a, StepSide::kRight, values_.camera.data());
    for (std::size_t t = 0; t < model.targets.size(); ++t) {
      add_pose_prior(model.targets[t].T_b_M, StepSide::kLeft, values_.mounts[t].data());
      add_scalar_prior(model.targets[t].scale, &values_.scales[t]);
    }
    for (std::size_t j = 0; j < model.offsets.size(); ++j) add_scalar_prior(model.offsets[j], &values_.offsets[j]);
  }

  ChainModel scratch_;
  UnknownValues values_;
  PoseManifold right_{StepSide::kRight}, left_{StepSide::kLeft};
  ceres::Problem problem_;
};

}  // namespace

Refined refine(const ChainModel& model, const std::vector<Observation>& observations, const std::vector<char>& used,
               const BatchOptions& options, double width) {
  Refinement refinement(model, observations, used, options, width);
  const auto summary = refinement.solve(options.max_iterations);
  return {refinement.result(), static_cast<int>(summary.iterations.size()),
          summary.termination_type == ceres::CONVERGENCE};
}

double jacobian_disagreement(const ChainModel& model, const std::vector<Observation>& observations,
                             const NoiseModel& noise) {
  PoseManifold right(StepSide::kRight), left(StepSide::kLeft);
  ChainModel scratch = model;
  UnknownValues values(model);
  double worst = 0.0;
  for (const auto& z : observations) {
    LookCost cost(scratch, z, square_root_information(model, z, noise));
    const auto blocks = cost.blocks(values);
    std::vector<const ceres::Manifold*> manifolds(blocks.size(), nullptr);
    manifolds[0] = &right;
    manifolds[1] = &left;
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
