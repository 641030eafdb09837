#include "host/learn_dataset.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "host/observability.hpp"
#include "host/stream_alignment.hpp"

namespace armsight::host {
namespace {

bool is_seen(std::size_t target, const std::vector<Observation>& looks) {
  return std::any_of(looks.begin(), looks.end(), [&](const auto& z) { return z.target == static_cast<int>(target); });
}

void fill_sigma(const BatchSolution& solution, DatasetCalibration& result) {
  const UnknownLayout layout = unknown_layout(solution.model);
  const Eigen::MatrixXd P = covariance_of(solution.model, solution.observations, solution.used, solution.noise);
  for (const auto& block : layout.blocks) {
    if (block.size != 1 || block.kind == UnknownBlock::Kind::kTime) continue;
    const bool is_offset = block.kind == UnknownBlock::Kind::kOffset;
    const auto index = static_cast<std::size_t>(block.index);
    // The noise stated may not be the noise found: σ follows the residuals' own size, as for any least-squares fit.
    const double sigma = std::max(solution.misfit, 1.0) * std::sqrt(P(block.column, block.column));
    result.sigma.emplace_back((is_offset ? "offset of " : "scale of ") +
                                  (is_offset ? solution.model.offsets[index].name : solution.model.targets[index].name),
                              sigma);
  }
}

/// All that comes before the choice of blocks.
struct Begun {
  DatasetCalibration result;
  ChainModel mounts;
  BatchSolution learnt;
  BlockOptions blocks;
};

Begun begin(const Dataset& dataset, const DatasetOptions& options) {
  Begun begun;
  DatasetCalibration& result = begun.result;
  const BatchOptions batch = batch_options(dataset, options.cost);
  result.left_out = dataset.left_out;
  result.looks = dataset.observations;
  if (dataset.stream) {
    const Dataset places = without_repeats(dataset);
    const TimeOffset offset = estimate_time_offset(places, batch);
    result.time_offset_s = offset.offset_s;
    result.time_offset_sigma_s = offset.sigma_s;
    result.looks = looks_at_offset(places, offset.offset_s, &result.left_out);
  }
  result.looks = observations_for(options.cost, dataset.model, result.looks);
  begun.mounts = mounts_of(dataset, result.looks);
  begun.learnt = learn(begun.mounts, result.looks, batch);
  begun.blocks = block_options(dataset, result.looks, options);
  const Gauges gauges = take_out_gauges(begun.mounts, begun.learnt, begun.blocks);
  result.parameters = gauges.parameters;
  result.rank = gauges.rank;
  result.unobservable = gauges.unobservable;
  return begun;
}

void finish(DatasetCalibration& result) {
  result.solution = result.chosen().solution;
  for (const auto& look : result.solution.looks) {
    const auto i = static_cast<std::size_t>(&look - result.solution.looks.data());
    if (!look.used) result.left_out.push_back({result.looks[i].label, look.reason});
  }
  fill_sigma(result.solution, result);
}

}  // namespace

ChainModel mounts_of(const Dataset& dataset, const std::vector<Observation>& looks) {
  ChainModel model = dataset.model;
  for (std::size_t t = 0; t < model.targets.size(); ++t) {  // nobody looked at it: no unknown
    if (!is_seen(t, looks)) model.targets[t].T_b_M.freedom = Freedom::kFixed;
  }
  return model;
}

BatchOptions batch_options(const Dataset& dataset, LearnCost cost) {
  BatchOptions batch;
  batch.noise = dataset.noise;
  batch.estimates_noise = !dataset.noise_is_known;
  const bool has_corners = !dataset.observations.empty() && dataset.observations[0].has_corners();
  if (cost != LearnCost::kThesis && (cost != LearnCost::kPixels || !has_corners)) return batch;
  batch.noise = {};  // what the cost says, and nothing else
  batch.estimates_noise = false;
  batch.loss = RobustLoss::kNone;
  return batch;
}

BlockOptions block_options(const Dataset& dataset, const std::vector<Observation>& looks,
                           const DatasetOptions& options) {
  BlockOptions blocks;
  blocks.folds = dataset.folds;
  blocks.fold_seeds = options.fold_seeds;
  blocks.least_improvement = options.least_improvement;
  std::vector<char> moves(dataset.model.offsets.size(), 0);
  bool has_corners = false, has_free_target = false;
  for (const auto& z : looks) {
    for (const int joint : look_unknowns(dataset.model, z.target).joints) moves[static_cast<std::size_t>(joint)] = 1;
    has_corners |= z.has_corners();
    has_free_target |= dataset.model.targets[static_cast<std::size_t>(z.target)].T_b_M.freedom != Freedom::kFixed;
  }
  for (const int joint : dataset.offset_joints) {
    if (moves[static_cast<std::size_t>(joint)]) blocks.offset_joints.push_back(joint);
  }
  const bool has_joints = std::count(moves.begin(), moves.end(), char{1}) > 0;
  if (!blocks.offset_joints.empty()) blocks.allowed.push_back(ModelBlock::kOffsets);
  if (dataset.may_learn_scale && has_free_target) blocks.allowed.push_back(ModelBlock::kScale);
  if (dataset.may_learn_links && has_joints) blocks.allowed.push_back(ModelBlock::kLinks);
  if (dataset.may_learn_intrinsics && has_corners) blocks.allowed.push_back(ModelBlock::kIntrinsics);
  return blocks;
}

Gauges take_out_gauges(const ChainModel& mounts, const BatchSolution& learnt, BlockOptions& options) {
  ChainModel all = with_mounts_of(with_blocks(mounts, {ModelBlock::kOffsets}, options), learnt.model);
  for (auto& offset : all.offsets) {
    if (offset.freedom == Freedom::kPrior) offset.freedom = Freedom::kFree;
  }
  Gauges gauges;
  const Observability seen = observe(all, learnt.observations, learnt.used, learnt.noise);
  gauges.parameters = seen.parameters;
  gauges.rank = seen.rank;
  gauges.unobservable = hold_unobservable_offsets(all, learnt.observations, learnt.used, learnt.noise);
  std::erase_if(options.offset_joints, [&all](int joint) {
    return all.offsets[static_cast<std::size_t>(joint)].freedom == Freedom::kFixed;
  });
  if (options.offset_joints.empty()) std::erase(options.allowed, ModelBlock::kOffsets);
  return gauges;
}

DatasetCalibration calibrate_dataset(const Dataset& dataset, const DatasetOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Begun begun = begin(dataset, options);
  begun.result.choice = choose_blocks(begun.mounts, begun.learnt, begun.result.looks,
                                      batch_options(dataset, options.cost), begun.blocks);
  finish(begun.result);
  begun.result.solve_wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return begun.result;
}

DatasetCalibration learn_blocks(const Dataset& dataset, const std::vector<ModelBlock>& blocks, LearnCost cost) {
  DatasetOptions options;
  options.cost = cost;
  Begun begun = begin(dataset, options);
  BlocksTried only;
  only.blocks = blocks;
  only.problem = with_blocks(begun.mounts, blocks, begun.blocks);
  only.unknowns = unknown_layout(only.problem).columns;
  only.solution = solve_batch({with_mounts_of(only.problem, begun.learnt.model)}, begun.result.looks,
                              batch_options(dataset, cost));
  only.training = evaluate(only.solution.model, begun.result.looks, only.solution.noise);
  begun.result.choice.tried.push_back(only);
  finish(begun.result);
  return begun.result;
}

}  // namespace armsight::host
