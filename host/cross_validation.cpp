#include "host/cross_validation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "host/closed_form_starts.hpp"

namespace armsight::host {
namespace {

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double mean(const std::vector<double>& values) {
  return values.empty() ? 0.0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const auto above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace

void LookErrors::add(const ChainModel& model, const Observation& z, const NoiseModel& noise) {
  const double scale = model.targets[static_cast<std::size_t>(z.target)].scale.value;
  const Pose predicted = predicted_T_C_M(model, z);
  const Vector6 e = pose_error(z.T_C_M, {predicted.R, predicted.p / scale});
  mm.push_back(1e3 * e.head<3>().norm());
  deg.push_back(e.tail<3>().norm() / kDegree);
  const auto r = residual_only(model, z);
  if (!r) return;
  norm.push_back(look_norm(model, z, noise));
  if (!z.has_corners()) return;
  for (Eigen::Index k = 0; k < r->size(); k += 2) px2.push_back(r->segment<2>(k).norm());
}

ErrorStatistics LookErrors::statistics() const {
  ErrorStatistics s;
  s.looks = static_cast<int>(mm.size());
  s.rms_mm = rms(mm);
  s.mean_mm = mean(mm);
  s.median_mm = quantile(mm, 0.5);
  s.p95_mm = quantile(mm, 0.95);
  s.rms_deg = rms(deg);
  s.median_deg = quantile(deg, 0.5);
  s.p95_deg = quantile(deg, 0.95);
  s.rms_px = rms(px2);
  std::vector<double> cut = norm;
  const double most = 3.0 * quantile(norm, 0.5);
  for (double& v : cut) v = std::min(v, most);
  s.robust_norm = rms(cut);
  return s;
}

ErrorStatistics evaluate(const ChainModel& model, const std::vector<Observation>& observations,
                         const NoiseModel& noise) {
  LookErrors errors;
  for (const auto& z : observations) errors.add(model, z, noise);
  return errors.statistics();
}

std::vector<int> make_folds(std::size_t count, int folds, unsigned seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(seed);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random() % i]);  // std::shuffle is not portable
  std::vector<int> fold(count);
  for (std::size_t k = 0; k < count; ++k) {
    fold[order[k]] = static_cast<int>(k * static_cast<std::size_t>(folds) / count);
  }
  return fold;
}

BatchSolution learn(const ChainModel& model, const std::vector<Observation>& observations,
                    const BatchOptions& options) {
  return solve_batch(closed_form_starts(model, observations), observations, options);
}

ChainModel with_mounts_of(const ChainModel& problem, const ChainModel& at) {
  ChainModel model = problem;
  model.T_C_a.value = at.T_C_a.value;
  for (std::size_t t = 0; t < model.targets.size(); ++t) model.targets[t].T_b_M.value = at.targets[t].T_b_M.value;
  return model;
}

HeldOut heldout_from(const ChainModel& start, const std::vector<Observation>& observations,
                     const BatchOptions& options, const std::vector<Observation>& judged, const NoiseModel& judge,
                     int folds, unsigned seed) {
  const auto fold = make_folds(observations.size(), folds, seed);
  HeldOut result;
  result.norm.assign(observations.size(), 0.0);
  for (int k = 0; k < folds; ++k) {
    std::vector<Observation> training;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (fold[i] != k) training.push_back(observations[i]);
    }
    if (training.empty()) continue;
    const ChainModel model = solve_batch({start}, training, options).model;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (fold[i] != k) continue;
      const Observation& z = judged[i];
      result.errors.add(model, z, judge);
      // The corners of one look are wrong together: whitened, they would tell of the lens and hardly of the arm.
      result.norm[i] = std::min(look_norm(model, z, z.has_corners() ? NoiseModel{} : judge), kFarNorm);
    }
  }
  return result;
}

ErrorStatistics median_over_splits(const std::vector<ErrorStatistics>& splits) {
  ErrorStatistics result = splits.front();
  for (double ErrorStatistics::*field :
       {&ErrorStatistics::rms_mm, &ErrorStatistics::median_mm, &ErrorStatistics::p95_mm, &ErrorStatistics::mean_mm,
        &ErrorStatistics::rms_deg, &ErrorStatistics::median_deg, &ErrorStatistics::p95_deg, &ErrorStatistics::rms_px,
        &ErrorStatistics::robust_norm}) {
    std::vector<double> values;
    for (const auto& s : splits) values.push_back(s.*field);
    result.*field = quantile(values, 0.5);
  }
  return result;
}

ErrorStatistics cross_validate(const ChainModel& model, const std::vector<Observation>& observations,
                               const BatchOptions& options, int folds, unsigned seed) {
  const auto fold = make_folds(observations.size(), folds, seed);
  BatchOptions quick = options;
  quick.refined_starts = 1;  // the start that scores best; the full fit has compared them already
  LookErrors errors;
  for (int k = 0; k < folds; ++k) {
    std::vector<Observation> training, heldout;
    for (std::size_t i = 0; i < observations.size(); ++i)
      (fold[i] == k ? heldout : training).push_back(observations[i]);
    if (training.empty() || heldout.empty()) continue;
    const BatchSolution solution = learn(model, training, quick);
    for (const auto& z : heldout) errors.add(solution.model, z, options.noise);
  }
  return errors.statistics();
}

}  // namespace armsight::host
