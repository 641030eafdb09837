#include "host/model_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace armsight::host {
namespace {

// What robots of all kinds may be off by before anybody calibrates them: one standard deviation.
constexpr double kScaleSigma = 0.05;
constexpr double kAxisSigma_m = 0.003, kAxisSigma_rad = 0.5 * kDegree;
constexpr double kFocalSigma = 0.03, kCentreSigma = 0.03;  // of the focal length; of the picture's width
constexpr double kRadialSigma = 0.1, kTangentialSigma = 0.005;

bool has(const std::vector<ModelBlock>& blocks, ModelBlock block) {
  return std::find(blocks.begin(), blocks.end(), block) != blocks.end();
}

void free_scalar(ScalarUnknown& scalar, double sigma) {
  scalar.freedom = Freedom::kPrior;
  scalar.prior = scalar.value;
  scalar.prior_sigma = sigma;
}

void free_intrinsics(ChainModel& model) {
  IntrinsicsUnknown& unknown = model.camera_unknown;
  unknown.freedom = Freedom::kPrior;
  unknown.prior = to_vector(model.camera);
  const double f = kFocalSigma * model.camera.fx, c = kCentreSigma * model.camera.width;
  unknown.prior_sigma << f, f, c, c, kRadialSigma, kRadialSigma, kTangentialSigma, kTangentialSigma, kRadialSigma;
}

/// The axes of all joints that some free target's looks depend on.
void free_axes(ChainModel& model) {
  model.axes.resize(model.offsets.size());
  for (std::size_t t = 0; t < model.targets.size(); ++t) {
    for (const int joint : look_unknowns(model, static_cast<int>(t)).joints) {
      AxisUnknown& axis = model.axes[static_cast<std::size_t>(joint)];
      axis.freedom = Freedom::kPrior;
      axis.prior_sigma_m = kAxisSigma_m;
      axis.prior_sigma_rad = kAxisSigma_rad;
    }
  }
}

double centre_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/// Squared norms, each cut at 3 medians: what one wild look says must not decide.
std::vector<double> cut_squares(const std::vector<double>& norms, double most) {
  std::vector<double> squares;
  for (const double norm : norms) squares.push_back(std::min(norm, most) * std::min(norm, most));
  return squares;
}

/// Is `after` better than `before` by the share and the standard errors asked for? Both by the same cut.
bool is_better(const BlocksTried& before, const BlocksTried& after, const BlockOptions& options) {
  const double most = 3.0 * centre_of(before.heldout_norm);
  const auto a = cut_squares(before.heldout_norm, most), b = cut_squares(after.heldout_norm, most);
  const auto n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n;
  const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double variance = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) variance += std::pow(a[i] - b[i] - (mean_a - mean_b), 2) / (n - 1.0);
  return std::sqrt(mean_b) < (1.0 - options.least_improvement) * std::sqrt(mean_a) &&
         mean_a - mean_b > options.least_sigmas * std::sqrt(variance / n);
}

/// From where the mounts stand, which is right to a few millimetres; looks of known noise as calibrate_arm does it, so
/// that both find the same bits.
BatchSolution fit(const ChainModel& problem, const BatchSolution& learnt, const std::vector<Observation>& looks,
                  const BatchOptions& batch) {
  if (!batch.estimates_noise) return learn(problem, looks, batch);
  return solve_batch({with_mounts_of(problem, learnt.model)}, looks, batch);
}

BlocksTried try_blocks(const ChainModel& mounts, const BatchSolution& learnt, const std::vector<ModelBlock>& blocks,
                       const std::vector<Observation>& looks, const BatchOptions& batch, const BlockOptions& options) {
  BlocksTried tried;
  tried.blocks = blocks;
  tried.problem = with_blocks(mounts, blocks, options);
  tried.unknowns = unknown_layout(tried.problem).columns;
  tried.solution = blocks.empty() ? learnt : fit(tried.problem, learnt, looks, batch);
  const NoiseModel& judge = learnt.noise;
  tried.training = evaluate(tried.solution.model, looks, judge);
  tried.heldout_norm.assign(looks.size(), 0.0);
  std::vector<ErrorStatistics> splits;
  BatchOptions inner = batch;
  inner.noise = tried.solution.noise;
  inner.estimates_noise = false;
  for (int seed = 1; seed <= options.fold_seeds; ++seed) {
    const HeldOut heldout =
        heldout_from(with_mounts_of(tried.problem, learnt.model), tried.solution.observations, inner,
                     learnt.observations, judge, options.folds, static_cast<unsigned>(seed));
    splits.push_back(heldout.errors.statistics());
    for (std::size_t i = 0; i < looks.size(); ++i) tried.heldout_norm[i] += heldout.norm[i] / options.fold_seeds;
  }
  tried.heldout = median_over_splits(splits);
  return tried;
}

}  // namespace

double compared_norm(const BlocksTried& tried, const BlocksTried& reference) {
  const auto squares = cut_squares(tried.heldout_norm, 3.0 * centre_of(reference.heldout_norm));
  return std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size()));
}

const char* name_of(ModelBlock block) {
  switch (block) {
    case ModelBlock::kOffsets: return "offsets";
    case ModelBlock::kScale: return "scale";
    case ModelBlock::kLinks: return "links";
    case ModelBlock::kIntrinsics: return "intrinsics";
  }
  return "";
}

std::string name_of(const std::vector<ModelBlock>& blocks) {
  std::string name;
  using enum ModelBlock;
  for (const ModelBlock block : {kOffsets, kLinks, kScale, kIntrinsics}) {
    if (has(blocks, block)) name += (name.empty() ? "+ " : " + ") + std::string(name_of(block));
  }
  return name.empty() ? "mounts only" : name;
}

ChainModel with_blocks(const ChainModel& mounts, const std::vector<ModelBlock>& blocks, const BlockOptions& options) {
  ChainModel model = mounts;
  if (has(blocks, ModelBlock::kOffsets) || has(blocks, ModelBlock::kLinks)) {
    for (const int joint : options.offset_joints) {
      free_scalar(model.offsets[static_cast<std::size_t>(joint)], kOffsetPriorSigma_rad);
    }
  }
  if (has(blocks, ModelBlock::kScale)) {
    for (auto& target : model.targets) {
      if (target.T_b_M.freedom != Freedom::kFixed) free_scalar(target.scale, kScaleSigma);
    }
  }
  if (has(blocks, ModelBlock::kLinks)) free_axes(model);
  if (has(blocks, ModelBlock::kIntrinsics)) free_intrinsics(model);
  return model;
}

BlockChoice choose_blocks(const ChainModel& mounts, const BatchSolution& learnt, const std::vector<Observation>& looks,
                          const BatchOptions& batch, const BlockOptions& options) {
  BlockChoice choice;
  choice.tried.push_back(try_blocks(mounts, learnt, {}, looks, batch, options));
  while (true) {
    const std::vector<ModelBlock> now = choice.tried[choice.chosen].blocks;
    std::size_t best = 0;
    for (const ModelBlock block : options.allowed) {
      if (has(now, block) || (block == ModelBlock::kOffsets && has(now, ModelBlock::kLinks))) continue;
      std::vector<ModelBlock> blocks = now;
      blocks.push_back(block);
      if (block == ModelBlock::kLinks) std::erase(blocks, ModelBlock::kOffsets);
      const auto is_same = [&](const BlocksTried& t) { return name_of(t.blocks) == name_of(blocks); };
      if (std::any_of(choice.tried.begin(), choice.tried.end(), is_same)) continue;
      choice.tried.push_back(try_blocks(mounts, learnt, blocks, looks, batch, options));
      const std::size_t last = choice.tried.size() - 1;
      if (!is_better(choice.tried[choice.chosen], choice.tried[last], options)) continue;
      const auto norm = [&choice](std::size_t i) { return compared_norm(choice.tried[i], choice.tried[0]); };
      if (best == 0 || norm(last) < norm(best)) best = last;
    }
    if (best == 0) return choice;
    choice.chosen = best;
  }
}

}  // namespace armsight::host
