#include "host/learn_dataset.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "host/observability.hpp"
#include "host/stream_alignment.hpp"

namespace armsight::host {
namespace {

ChainModel with_offsets(ChainModel model, const std::vector<int>& joints) {
  for (const int joint : joints) model.offsets[static_cast<std::size_t>(joint)].freedom = Freedom::kFree;
  return model;
}

ChainModel with_scale(ChainModel model) {
  for (auto& target : model.targets) target.scale.freedom = Freedom::kFree;
  return model;
}

/// Targets nobody looked at must not stand in the problem as unknowns.
ChainModel without_unseen_targets(ChainModel model, const std::vector<Observation>& looks) {
  for (std::size_t t = 0; t < model.targets.size(); ++t) {
    const bool is_seen =
        std::any_of(looks.begin(), looks.end(), [t](const auto& z) { return z.target == static_cast<int>(t); });
    if (!is_seen) model.targets[t].T_b_M.freedom = Freedom::kFixed;
  }
  return model;
}

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

ErrorStatistics median_over_seeds(const std::vector<ErrorStatistics>& each) {
  ErrorStatistics result = each.front();
  for (double ErrorStatistics::*field :
       {&ErrorStatistics::rms_mm, &ErrorStatistics::median_mm, &ErrorStatistics::p95_mm, &ErrorStatistics::mean_mm,
        &ErrorStatistics::rms_deg, &ErrorStatistics::median_deg, &ErrorStatistics::p95_deg, &ErrorStatistics::rms_px,
        &ErrorStatistics::robust_norm}) {
    std::vector<double> values;
    for (const auto& s : each) values.push_back(s.*field);
    result.*field = median_of(values);
  }
  return result;
}

CandidateResult try_candidate(const std::string& name, const ChainModel& problem, const std::vector<Observation>& looks,
                              const BatchOptions& batch, const Dataset& dataset, const DatasetOptions& options,
                              BatchSolution& solution) {
  CandidateResult result{name, problem, unknown_layout(problem).columns, {}, {}};
  solution = learn(problem, looks, batch);
  result.training = evaluate(solution.model, looks, batch.noise);
  std::vector<ErrorStatistics> seeds;
  for (int seed = 1; seed <= options.fold_seeds; ++seed) {
    seeds.push_back(cross_validate(problem, looks, batch, dataset.folds, static_cast<unsigned>(seed)));
  }
  result.heldout = median_over_seeds(seeds);
  return result;
}

/// Null space with every candidate offset free at the mounts-only solution; `problem` comes back with those held.
void look_for_gauges(ChainModel& problem, const BatchSolution& mounts, const std::vector<Observation>& looks,
                     const NoiseModel& noise, DatasetCalibration& result) {
  ChainModel at_solution = problem;
  at_solution.T_C_a.value = mounts.model.T_C_a.value;
  for (std::size_t t = 0; t < at_solution.targets.size(); ++t) {
    at_solution.targets[t].T_b_M.value = mounts.model.targets[t].T_b_M.value;
  }
  const Observability seen = observe(at_solution, looks, mounts.used, noise);
  result.parameters = seen.parameters;
  result.rank = seen.rank;
  result.unobservable = hold_unobservable_offsets(at_solution, looks, mounts.used, noise);
  for (std::size_t j = 0; j < problem.offsets.size(); ++j) problem.offsets[j].freedom = at_solution.offsets[j].freedom;
}

void fill_sigma(const BatchSolution& solution, const NoiseModel& noise, DatasetCalibration& result) {
  const UnknownLayout layout = unknown_layout(solution.model);
  const Eigen::MatrixXd P = covariance_of(solution.model, solution.observations, solution.used, noise);
  for (const auto& block : layout.blocks) {
    if (block.size != 1) continue;
    const bool is_offset = block.kind == UnknownBlock::Kind::kOffset;
    const auto index = static_cast<std::size_t>(block.index);
    // The noise stated may not be the noise found: σ follows the residuals' own size, as for any least-squares fit.
    const double sigma = std::max(solution.misfit, 1.0) * std::sqrt(P(block.column, block.column));
    result.sigma.emplace_back((is_offset ? "offset of " : "scale of ") +
                                  (is_offset ? solution.model.offsets[index].name : solution.model.targets[index].name),
                              sigma);
  }
}

}  // namespace

std::size_t choose_by_heldout(const std::vector<CandidateResult>& candidates, double least_improvement) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    const double wanted = candidates[best].heldout.robust_norm * (1.0 - least_improvement);
    if (candidates[i].heldout.robust_norm < wanted) best = i;
  }
  return best;
}

DatasetCalibration calibrate_dataset(const Dataset& dataset, const DatasetOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  DatasetCalibration result;
  BatchOptions batch;
  batch.noise = dataset.noise;
  result.left_out = dataset.left_out;
  result.looks = dataset.observations;
  if (dataset.stream) {
    result.time_offset_s = estimate_time_offset_s(dataset, batch);
    result.looks = looks_at_offset(dataset, *result.time_offset_s, &result.left_out);
  }
  const ChainModel mounts = without_unseen_targets(dataset.model, result.looks);
  std::vector<BatchSolution> solutions(1);
  result.candidates.push_back(
      try_candidate("mounts only", mounts, result.looks, batch, dataset, options, solutions[0]));
  ChainModel offsets = with_offsets(mounts, dataset.offset_joints);
  look_for_gauges(offsets, solutions[0], result.looks, batch.noise, result);
  const auto add = [&](const char* name, const ChainModel& problem) {
    solutions.emplace_back();
    result.candidates.push_back(try_candidate(name, problem, result.looks, batch, dataset, options, solutions.back()));
  };
  const bool has_offsets = unknown_layout(offsets).columns > unknown_layout(mounts).columns;
  if (has_offsets) add("+ offsets", offsets);
  if (dataset.scale_candidate) add("+ scale", with_scale(mounts));
  if (has_offsets && dataset.scale_candidate) add("+ offsets + scale", with_scale(offsets));

  result.chosen = choose_by_heldout(result.candidates, options.least_improvement);
  result.solution = solutions[result.chosen];
  for (const auto& look : result.solution.looks) {
    const auto i = static_cast<std::size_t>(&look - result.solution.looks.data());
    if (!look.used) result.left_out.push_back({result.looks[i].label, look.reason});
  }
  fill_sigma(result.solution, batch.noise, result);
  result.solve_wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace armsight::host
