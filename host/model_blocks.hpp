// Which errors of the robot do these looks give reason to believe in? Blocks of unknowns, each with a prior, added to
// the mounts one by one while looks that were not learnt from are predicted better (F-C7, calibration.md §0.7, §4.4);
// the training error decides nothing.
#pragma once

#include <string>
#include <vector>

#include "host/cross_validation.hpp"

namespace armsight::host {

/// What a joint's zero may be off by before anybody calibrates it: one standard deviation.
inline constexpr double kOffsetPriorSigma_rad = 5.0 * kDegree;

enum class ModelBlock { kOffsets, kScale, kLinks, kIntrinsics };
const char* name_of(ModelBlock block);
/// "mounts only", "+ offsets + scale", …
std::string name_of(const std::vector<ModelBlock>& blocks);

/// What may be switched on, and which joints' offsets may be wrong.
struct BlockOptions {
  std::vector<ModelBlock> allowed;
  std::vector<int> offset_joints;
  double least_improvement = 0.02;  ///< a block must lower the held-out error by this share ...
  double least_sigmas = 1.0;        ///< ... and by so many of the improvement's own standard errors
  int folds = 5;
  int fold_seeds = 1;               ///< splits that a comparison is averaged over
};

/// `mounts` with these blocks free, each about its nominal value with its prior. Links bring the offsets with them.
ChainModel with_blocks(const ChainModel& mounts, const std::vector<ModelBlock>& blocks, const BlockOptions& options);

struct BlocksTried {
  std::vector<ModelBlock> blocks;
  ChainModel problem;
  int unknowns = 0;
  BatchSolution solution;              ///< from all the looks
  ErrorStatistics training, heldout;   ///< over all looks, outliers included; held-out: median over the splits
  std::vector<double> heldout_norm;    ///< of each look, mean over the splits, whitened by the mounts' noise
};

/// Rms of heldout_norm, each cut at 3 medians of `reference`'s: what the choice compares.
double compared_norm(const BlocksTried& tried, const BlocksTried& reference);

struct BlockChoice {
  std::vector<BlocksTried> tried;      ///< the mounts alone first
  std::size_t chosen = 0;
};

/// `mounts` and what was learnt of them from `looks`; offsets held as gauges must be kFixed and not among
/// options.offset_joints.
BlockChoice choose_blocks(const ChainModel& mounts, const BatchSolution& learnt, const std::vector<Observation>& looks,
                          const BatchOptions& batch, const BlockOptions& options);

}  // namespace armsight::host
