#include "host/nested_validation.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

#include "host/stream_alignment.hpp"

namespace armsight::host {
namespace {

struct Part {
  LookErrors errors;
  std::string chosen;
};

Dataset part_of(const Dataset& dataset, const std::vector<int>& fold, int k, bool heldout) {
  Dataset part = dataset;
  part.observations.clear();
  part.look_time_s.clear();
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    if ((fold[i] == k) != heldout) continue;
    part.observations.push_back(dataset.observations[i]);
    if (!dataset.look_time_s.empty()) part.look_time_s.push_back(dataset.look_time_s[i]);
  }
  return part;
}

/// Learns from all folds but k and adds the errors on fold k.
void run_fold(const Dataset& dataset, const std::vector<int>& fold, int k, const NestedOptions& options, Part& part) {
  const Dataset training = part_of(dataset, fold, k, false);
  Dataset heldout = part_of(dataset, fold, k, true);
  if (training.observations.empty() || heldout.observations.empty()) return;
  DatasetOptions learn_options;
  learn_options.fold_seeds = 1;
  learn_options.cost = options.cost;
  const DatasetCalibration result = options.blocks ? learn_blocks(training, *options.blocks, options.cost)
                                                   : calibrate_dataset(training, learn_options);
  if (dataset.stream) heldout.observations = looks_at_offset(heldout, *result.time_offset_s, nullptr);
  part.chosen = name_of(result.chosen().blocks);
  for (const auto& z : heldout.observations) part.errors.add(result.solution.model, z, result.solution.noise);
}

void append(std::vector<double>& to, const std::vector<double>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

Dataset without(const Dataset& dataset, const std::vector<std::string>& labels) {
  std::vector<int> is_out;
  for (const auto& z : dataset.observations) {
    is_out.push_back(std::find(labels.begin(), labels.end(), z.label) != labels.end() ? 1 : 0);
  }
  return part_of(dataset, is_out, 0, true);
}

}  // namespace

NestedResult validate_learn(const Dataset& all, const NestedOptions& options) {
  const Dataset dataset = without(all, options.left_out);
  const auto folds = static_cast<std::size_t>(dataset.folds);
  const std::size_t jobs = static_cast<std::size_t>(options.fold_seeds) * folds;
  std::vector<Part> parts(jobs);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t job = next++; job < jobs; job = next++) {
      const auto fold = make_folds(dataset.observations.size(), dataset.folds, static_cast<unsigned>(job / folds + 1));
      run_fold(dataset, fold, static_cast<int>(job % folds), options, parts[job]);
    }
  };
  {
    std::vector<std::jthread> workers;
    for (unsigned w = 1; w < std::max(std::thread::hardware_concurrency(), 1u); ++w) workers.emplace_back(work);
    work();
  }
  NestedResult result;
  std::vector<ErrorStatistics> splits;
  for (std::size_t seed = 0; seed < static_cast<std::size_t>(options.fold_seeds); ++seed) {
    LookErrors pooled;
    for (std::size_t k = 0; k < folds; ++k) {
      const Part& part = parts[seed * folds + k];
      append(pooled.mm, part.errors.mm);
      append(pooled.deg, part.errors.deg);
      append(pooled.px2, part.errors.px2);
      append(pooled.norm, part.errors.norm);
      ++result.chosen[part.chosen];
    }
    splits.push_back(pooled.statistics());
  }
  result.heldout = median_over_splits(splits);
  return result;
}

}  // namespace armsight::host
