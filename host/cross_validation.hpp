// Is the model right on looks it never saw? k-fold over looks (by pose, a seeded permutation cut into equal parts),
// and the choice between models by that error, never by the training error; calibration.md §4.4.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/batch_calibration.hpp"

namespace armsight::host {

struct ErrorStatistics {
  int looks = 0;
  double rms_mm = 0.0, median_mm = 0.0, p95_mm = 0.0, mean_mm = 0.0;
  double rms_deg = 0.0, median_deg = 0.0, p95_deg = 0.0;
  double rms_px = 0.0;        ///< corners only
  double robust_norm = 0.0;   ///< rms of whitened norms, each cut at 3 times their median: compares models
};

/// Residuals of the observations at this model, every one of them, outliers included.
struct LookErrors {
  std::vector<double> mm, deg, px2, norm;
  void add(const ChainModel& model, const Observation& z, const NoiseModel& noise);
  ErrorStatistics statistics() const;
};
ErrorStatistics evaluate(const ChainModel& model, const std::vector<Observation>& observations,
                         const NoiseModel& noise);

/// Fold of each observation, 0 … folds−1; deterministic by seed on every machine.
std::vector<int> make_folds(std::size_t count, int folds, unsigned seed);

/// Closed-form starts of `model` (its value among them), then solve_batch.
BatchSolution learn(const ChainModel& model, const std::vector<Observation>& observations,
                    const BatchOptions& options);

/// `problem` with the poses of `at`, of camera and targets.
ChainModel with_mounts_of(const ChainModel& problem, const ChainModel& at);

struct HeldOut {
  LookErrors errors;
  std::vector<double> norm;  ///< of each look, in the looks' order: poses whitened by `judge`, corners rms in σ_px
};
/// Every look predicted by a model learnt without it, each fold's fit begun at `start`. `judged` are the same looks
/// with the noise that all models to be compared are judged by.
HeldOut heldout_from(const ChainModel& start, const std::vector<Observation>& observations,
                     const BatchOptions& options, const std::vector<Observation>& judged, const NoiseModel& judge,
                     int folds, unsigned seed);

/// Field by field.
ErrorStatistics median_over_splits(const std::vector<ErrorStatistics>& splits);

/// Held-out errors: every look predicted by a model learnt without it (its outliers named inside each fold).
ErrorStatistics cross_validate(const ChainModel& model, const std::vector<Observation>& observations,
                               const BatchOptions& options, int folds, unsigned seed);

}  // namespace armsight::host
