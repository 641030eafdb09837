#include "host/batch_calibration.hpp"

#include <ceres/gradient_checker.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "host/batch_calibration_cost.hpp"

namespace armsight::host {
namespace {

constexpr double kFar = 1e9;  // norm of a look whose corners fall behind the camera

double look_norm(const ChainModel& model, const Observation& z, const NoiseModel& noise) {
  const auto r = residual_only(model, z);
  if (!r) return kFar;
  return (square_root_information(model, z, noise) * *r).norm() / std::sqrt(static_cast<double>(z.rows()));
}

std::vector<double> look_norms(const ChainModel& model, const std::vector<Observation>& observations,
                               const NoiseModel& noise) {
  std::vector<double> norms;
  for (const auto& z : observations) norms.push_back(look_norm(model, z, noise));
  return norms;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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

double loss_width(const std::vector<double>& norms, const std::vector<char>& used, const BatchOptions& options) {
  std::vector<double> kept;
  for (std::size_t i = 0; i < norms.size(); ++i) {
    if (used[i]) kept.push_back(norms[i]);
  }
  return options.loss_per_median * std::max(median(kept), 0.05);  // a perfect set must not narrow it to nothing
}

/// One reweighting round: weights and width at the model, then Levenberg-Marquardt.
void refine_once(BatchSolution& solution, const BatchOptions& options) {
  const auto norms = look_norms(solution.model, solution.observations, options.noise);
  Refinement refinement(solution.model, solution.observations, solution.used, options,
                        loss_width(norms, solution.used, options));
  const auto summary = refinement.solve(options.max_iterations);
  solution.model = refinement.result();
  solution.iterations += static_cast<int>(summary.iterations.size());
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
}

void take_better_second_solutions(BatchSolution& solution, const NoiseModel& noise) {
  for (std::size_t i = 0; i < solution.observations.size(); ++i) {
    Observation& z = solution.observations[i];
    if (!z.T_C_M_second || z.has_corners()) continue;
    Observation other = z;
    std::swap(other.T_C_M, *other.T_C_M_second);
    if (look_norm(solution.model, other, noise) >= look_norm(solution.model, z, noise)) continue;
    z = other;
    solution.looks[i].second_solution = !solution.looks[i].second_solution;
  }
}

std::string outlier_reason(const ChainModel& model, const Observation& z, double norm, double typical) {
  const auto r = residual_only(model, z);
  char text[160];
  if (!r) return "its corners fall behind the camera";
  if (z.has_corners()) {
    const double rms_px = std::sqrt(r->squaredNorm() / static_cast<double>(z.pixels.size()));
    std::snprintf(text, sizeof text, "%.1f px off, %.1f times the median look", rms_px, norm / typical);
  } else {
    std::snprintf(text, sizeof text, "%.1f mm and %.1f deg off, %.1f times the median look", 1e3 * r->head<3>().norm(),
                  180.0 / M_PI * r->tail<3>().norm(), norm / typical);
  }
  return text;
}

/// Marks the looks whose norm stands far outside the others' spread.
void mark_outliers(BatchSolution& solution, const BatchOptions& options) {
  const auto norms = look_norms(solution.model, solution.observations, options.noise);
  const double typical = std::max(median(norms), 0.3);
  for (std::size_t i = 0; i < norms.size(); ++i) {
    LookFit& look = solution.looks[i];
    look.norm = norms[i];
    look.used = options.loss == RobustLoss::kNone || norms[i] <= options.outlier_per_median * typical;
    look.reason = look.used ? "" : outlier_reason(solution.model, solution.observations[i], norms[i], typical);
    solution.used[i] = look.used ? 1 : 0;
  }
}

void finish(BatchSolution& solution, const BatchOptions& options) {
  mark_outliers(solution, options);
  double sum = 0.0;
  int count = 0;
  for (const auto& look : solution.looks) {
    sum += look.used ? look.norm * look.norm : 0.0;
    count += look.used ? 1 : 0;
  }
  solution.misfit = count > 0 ? std::sqrt(sum / count) : 0.0;
}

BatchSolution begin(const ChainModel& start, const std::vector<Observation>& observations) {
  BatchSolution solution;
  solution.model = start;
  solution.observations = observations;
  solution.looks.resize(observations.size());
  solution.used.assign(observations.size(), 1);
  return solution;
}

}  // namespace

double robust_score(const ChainModel& model, const std::vector<Observation>& observations, const NoiseModel& noise) {
  double score = 0.0;
  for (const double norm : look_norms(model, observations, noise)) score += std::log1p(norm * norm / 9.0);
  return score;
}

BatchSolution solve_batch(const std::vector<ChainModel>& starts, const std::vector<Observation>& observations,
                          const BatchOptions& options) {
  if (starts.empty() || observations.empty()) throw std::invalid_argument("solve_batch: no start or no observation");
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t s = 0; s < starts.size(); ++s) {
    order.emplace_back(robust_score(starts[s], observations, options.noise), s);
  }
  std::sort(order.begin(), order.end());
  BatchSolution best;
  double best_score = std::numeric_limits<double>::infinity();
  const auto refined = std::min(order.size(), static_cast<std::size_t>(options.refined_starts));
  for (std::size_t k = 0; k < refined; ++k) {
    BatchSolution solution = begin(starts[order[k].second], observations);
    refine_once(solution, options);
    take_better_second_solutions(solution, options.noise);
    const double score = robust_score(solution.model, solution.observations, options.noise);
    if (score < best_score || best.looks.empty()) {
      best = std::move(solution);
      best_score = score;
    }
  }
  for (int round = 1; round < options.rounds; ++round) {
    mark_outliers(best, options);
    refine_once(best, options);
    take_better_second_solutions(best, options.noise);
  }
  finish(best, options);
  return best;
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
