// Learn on a recorded data set: models from few to many unknowns, compared by held-out error, never by training error
// (calibration.md §0.7, §4.4); what cannot be told, in words; `host calibrate --dataset DIR` prints it.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "host/dataset.hpp"
#include "host/model_blocks.hpp"

namespace armsight::host {

struct DatasetOptions {
  LearnCost cost = LearnCost::kLikelihood;
  int fold_seeds = 3;                  ///< held-out figures are medians over so many splits
  double least_improvement = 0.02;     ///< a richer model must lower the held-out error by this share
};

struct DatasetCalibration {
  std::optional<double> time_offset_s; ///< t_arm − t_look, two-stream sets ...
  double time_offset_sigma_s = 0.0;    ///< ... and its standard deviation beside the mounts
  std::vector<Observation> looks;      ///< learnt from; two-stream sets: one a place where the arm stood
  std::vector<LeftOut> left_out;       ///< rows without an observation, then outliers, each with its reason
  BlockChoice choice;                  ///< models tried, the mounts alone first
  BatchSolution solution;              ///< of the chosen one
  int parameters = 0, rank = 0;        ///< with every candidate offset free
  std::vector<std::string> unobservable;
  std::vector<std::pair<std::string, double>> sigma;  ///< of offsets (rad) and scales, chosen model
  const BlocksTried& chosen() const { return choice.tried[choice.chosen]; }
  double solve_wall_s = 0.0;
};

DatasetCalibration calibrate_dataset(const Dataset& dataset, const DatasetOptions& options);

/// The same with these blocks free, whatever the looks say of them; nothing is held out.
DatasetCalibration learn_blocks(const Dataset& dataset, const std::vector<ModelBlock>& blocks,
                                LearnCost cost = LearnCost::kLikelihood);

/// What is free in the mounts alone, unseen targets held; looks of two streams come from calibrate_dataset.
ChainModel mounts_of(const Dataset& dataset, const std::vector<Observation>& looks);
BatchOptions batch_options(const Dataset& dataset, LearnCost cost);
/// What of the dataset's own wishes can be tried on these looks; the offsets that are gauges taken out.
BlockOptions block_options(const Dataset& dataset, const std::vector<Observation>& looks,
                           const DatasetOptions& options);

/// The null space with every candidate offset free, at what was learnt of the mounts; offsets that are gauges leave
/// options.offset_joints and are named.
struct Gauges {
  int parameters = 0, rank = 0;
  std::vector<std::string> unobservable;
};
Gauges take_out_gauges(const ChainModel& mounts, const BatchSolution& learnt, BlockOptions& options);

/// Whether joint offsets by themselves lower the training error and raise the held-out one; empty: they do not.
std::string offsets_alone_in_words(const DatasetCalibration& result);
/// By what share they change the held-out error, as the choice compares it; nothing where they were not tried.
std::optional<double> offsets_alone_change(const DatasetCalibration& result);

/// People's text and, for `out_file`, JSON.
void print_calibration(const Dataset& dataset, const DatasetCalibration& result, std::ostream& out);
std::string calibration_json(const Dataset& dataset, const DatasetCalibration& result);

/// "likelihood", "poses", "pixels", "thesis".
LearnCost learn_cost(const std::string& name);

/// The verb: reads, solves, prints, writes JSON to out_file (none if empty). 0 done, 1 refused; throws ConfigError.
int run_calibrate_dataset(const std::filesystem::path& folder, const std::filesystem::path& out_file, LearnCost cost,
                          std::ostream& out);

}  // namespace armsight::host
