// Levenberg-Marquardt on the normal equations: a few dozen unknowns, thousands of rows, so each look adds its small
// JᵀJ and no general solver's bookkeeping is paid for. The loss weighs a look's rows by ρ'(‖W r‖²).
#include "host/batch_calibration_refine.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/look_weight.hpp"

namespace armsight::host {
namespace {

constexpr double kImpossible = std::numeric_limits<double>::infinity();

struct Loss {
  double value, slope;  ///< ρ(s), ρ'(s)
};

Loss robust(RobustLoss loss, double s, double width) {
  const double w2 = width * width;
  switch (loss) {
    case RobustLoss::kCauchy: return {w2 * std::log1p(s / w2), 1.0 / (1.0 + s / w2)};
    case RobustLoss::kHuber:
      if (s > w2) return {2.0 * width * std::sqrt(s) - w2, width / std::sqrt(s)};
      break;
    case RobustLoss::kNone: break;
  }
  return {s, 1.0};
}

struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double cost = 0.0;
};

class Refinement {
 public:
  Refinement(const ChainModel& model, const std::vector<Observation>& observations, const std::vector<char>& used,
             const BatchOptions& options, double width)
      : observations_(observations), used_(used), options_(options), width_(width), layout_(unknown_layout(model)) {
    for (std::size_t t = 0; t < model.targets.size(); ++t) add_target(look_unknowns(model, static_cast<int>(t)));
    weights_.reserve(observations.size());
    for (std::size_t i = 0; i < observations.size(); ++i) {
      weights_.push_back(used[i] ? std::optional<LookWeight>(LookWeight(model, observations[i], options.noise))
                                 : std::nullopt);
    }
  }

  double cost(const ChainModel& model) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (!used_[i]) continue;
      const auto r = residual_only(model, observations_[i]);
      if (!r) return kImpossible;
      sum += loss_of(i, (*weights_[i] * *r).squaredNorm()).value;
    }
    Eigen::VectorXd r;
    Eigen::MatrixXd J;
    prior_residuals(model, layout_, r, J);
    return sum + r.squaredNorm();
  }

  /// cost = ∞ where a corner falls behind the camera.
  NormalEquations linearise(const ChainModel& model) const {
    NormalEquations equations;
    Eigen::VectorXd r_prior;
    Eigen::MatrixXd J_prior;
    prior_residuals(model, layout_, r_prior, J_prior);
    equations.H.noalias() = J_prior.transpose() * J_prior;
    equations.g.noalias() = J_prior.transpose() * r_prior;
    equations.cost = r_prior.squaredNorm();
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (used_[i] && !add_look(model, i, equations)) equations.cost = kImpossible;
    }
    return equations;
  }

  const UnknownLayout& layout() const { return layout_; }

 private:
  struct TargetColumns {
    LookUnknowns look;
    std::vector<std::pair<int, int>> from_to;  ///< column of the look, column of the problem
  };

  void add_target(const LookUnknowns& look) {
    TargetColumns columns{look, {}};
    for (const auto& block : look.blocks) {
      const UnknownBlock* global = layout_.find(block.kind, block.index);
      for (int c = 0; global && c < block.size; ++c) {
        columns.from_to.emplace_back(block.column + c, global->column + c);
      }
    }
    targets_.push_back(std::move(columns));
  }

  Loss loss_of(std::size_t i, double squared) const {
    return robust(options_.loss, squared, width_ * std::sqrt(static_cast<double>(observations_[i].rows())));
  }

  bool add_look(const ChainModel& model, std::size_t i, NormalEquations& equations) const {
    const TargetColumns& columns = targets_[static_cast<std::size_t>(observations_[i].target)];
    const auto residual = residual_of(model, observations_[i], columns.look);
    if (!residual) return false;
    const auto count = static_cast<Eigen::Index>(columns.from_to.size());
    Eigen::MatrixXd J(residual->J.rows(), count);
    for (Eigen::Index c = 0; c < count; ++c) {
      J.col(c) = residual->J.col(columns.from_to[static_cast<std::size_t>(c)].first);
    }
    const Eigen::MatrixXd A = *weights_[i] * J;
    const Eigen::VectorXd r = *weights_[i] * residual->r;
    const Loss loss = loss_of(i, r.squaredNorm());
    const Eigen::MatrixXd H = A.transpose() * A;
    const Eigen::VectorXd g = A.transpose() * r;
    for (Eigen::Index a = 0; a < count; ++a) {
      const int row = columns.from_to[static_cast<std::size_t>(a)].second;
      equations.g[row] += loss.slope * g[a];
      for (Eigen::Index b = 0; b < count; ++b) {
        equations.H(row, columns.from_to[static_cast<std::size_t>(b)].second) += loss.slope * H(a, b);
      }
    }
    equations.cost += loss.value;
    return true;
  }

  const std::vector<Observation>& observations_;
  const std::vector<char>& used_;
  const BatchOptions& options_;
  double width_;
  UnknownLayout layout_;
  std::vector<TargetColumns> targets_;
  std::vector<std::optional<LookWeight>> weights_;
};

/// Solves (H + λ diag H) x = −g; columns that nothing depends on keep still.
Eigen::VectorXd damped_step(const NormalEquations& equations, double lambda) {
  const Eigen::VectorXd diagonal = equations.H.diagonal();
  const Eigen::VectorXd scale =
      diagonal.unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
  Eigen::MatrixXd A = scale.asDiagonal() * equations.H * scale.asDiagonal();
  A.diagonal().array() += lambda;
  return -(scale.asDiagonal() * A.ldlt().solve(scale.cwiseProduct(equations.g))).eval();
}

}  // namespace

Refined refine(const ChainModel& model, const std::vector<Observation>& observations, const std::vector<char>& used,
               const BatchOptions& options, double width) {
  const Refinement problem(model, observations, used, options, width);
  Refined result{model, 0, false};
  if (problem.layout().columns == 0) return {model, 0, true};
  NormalEquations equations = problem.linearise(model);
  if (!std::isfinite(equations.cost)) return result;
  double lambda = 1e-4, growth = 2.0;
  while (result.iterations < options.max_iterations && !result.converged) {
    ++result.iterations;
    const Eigen::VectorXd x = damped_step(equations, lambda);
    const double forecast = -x.dot(2.0 * equations.g + equations.H * x);
    const ChainModel moved = retract(result.model, problem.layout(), x);
    const double cost = x.allFinite() ? problem.cost(moved) : kImpossible;
    const double gain = equations.cost - cost;
    if (gain > 0.0) {
      result.model = moved;
      result.converged = gain <= 1e-13 * equations.cost;
      equations = problem.linearise(moved);
      const double quality = forecast > 0.0 ? gain / forecast : 1.0;
      lambda = std::max(lambda * std::max(0.1, 1.0 - std::pow(2.0 * quality - 1.0, 3)), 1e-12);
      growth = 2.0;
    } else {
      result.converged = forecast <= 1e-13 * equations.cost || lambda > 1e12;
      lambda *= growth;
      growth *= 2.0;
    }
  }
  return result;
}

}  // namespace armsight::host
