#include "host/batch_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "host/batch_calibration_refine.hpp"
#include "host/noise_estimate.hpp"

namespace armsight::host {
namespace {

constexpr double kLeastSigma_px = 0.01;  // rendered pictures: nothing is better known

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

double loss_width(const std::vector<double>& norms, const std::vector<char>& used, const BatchOptions& options) {
  std::vector<double> kept;
  for (std::size_t i = 0; i < norms.size(); ++i) {
    if (used[i]) kept.push_back(norms[i]);
  }
  return options.loss_per_median * std::max(median(kept), 0.05);  // a perfect set must not narrow it to nothing
}

/// One reweighting round: weights and width at the model, then Levenberg-Marquardt.
void refine_once(BatchSolution& solution, const BatchOptions& options) {
  const auto norms = look_norms(solution.model, solution.observations, solution.noise);
  BatchOptions at_noise = options;
  at_noise.noise = solution.noise;
  const Refined refined = refine(solution.model, solution.observations, solution.used, at_noise,
                                 loss_width(norms, solution.used, options));
  solution.model = refined.model;
  solution.iterations += refined.iterations;
  solution.converged = refined.converged;
}

void estimate_noise(BatchSolution& solution) {
  const double sigma_px = estimated_sigma_px(solution.model, solution.observations, solution.used);
  for (auto& z : solution.observations) z.sigma_px = sigma_px > 0.0 ? std::max(sigma_px, kLeastSigma_px) : z.sigma_px;
  solution.noise = estimated_floor(solution.model, solution.observations, solution.used, solution.noise);
}

void take_better_second_solutions(BatchSolution& solution) {
  const NoiseModel& noise = solution.noise;
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
                  r->tail<3>().norm() / kDegree, norm / typical);
  }
  return text;
}

/// Marks the looks whose norm stands far outside the others' spread.
void mark_outliers(BatchSolution& solution, const BatchOptions& options) {
  const auto norms = look_norms(solution.model, solution.observations, solution.noise);
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

BatchSolution begin(const ChainModel& start, const std::vector<Observation>& observations, const NoiseModel& noise) {
  BatchSolution solution;
  solution.model = start;
  solution.observations = observations;
  solution.noise = noise;
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
    BatchSolution solution = begin(starts[order[k].second], observations, options.noise);
    refine_once(solution, options);
    take_better_second_solutions(solution);
    const double score = robust_score(solution.model, solution.observations, options.noise);
    if (score < best_score || best.looks.empty()) {
      best = std::move(solution);
      best_score = score;
    }
  }
  for (int round = 1; round < options.rounds; ++round) {
    if (options.estimates_noise) estimate_noise(best);
    mark_outliers(best, options);
    refine_once(best, options);
    take_better_second_solutions(best);
  }
  finish(best, options);
  return best;
}

}  // namespace armsight::host
