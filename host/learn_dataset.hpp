// Learn on a recorded data set: models from few to many unknowns, compared by held-out error, never by training error
// (calibration.md §0.7, §4.4); what cannot be told, in words; `host calibrate --dataset DIR` prints it.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "host/cross_validation.hpp"
#include "host/dataset.hpp"

namespace armsight::host {

struct DatasetOptions {
  int fold_seeds = 3;                  ///< held-out figures are medians over so many splits
  double least_improvement = 0.02;     ///< a richer model must lower the held-out error by this share
};

struct CandidateResult {
  std::string name;                    ///< "mounts only", "+ offsets", …
  ChainModel problem;                  ///< what is free in it
  int unknowns = 0;
  ErrorStatistics training, heldout;   ///< over all looks, outliers included
};

struct DatasetCalibration {
  std::optional<double> time_offset_s; ///< t_arm − t_look, two-stream sets
  std::vector<Observation> looks;
  std::vector<LeftOut> left_out;       ///< rows without an observation, then outliers, each with its reason
  std::vector<CandidateResult> candidates;
  std::size_t chosen = 0;
  BatchSolution solution;              ///< of the chosen candidate
  int parameters = 0, rank = 0;        ///< with every candidate offset free
  std::vector<std::string> unobservable;
  std::vector<std::pair<std::string, double>> sigma;  ///< of offsets (rad) and scales, chosen model
  double solve_wall_s = 0.0;
};

DatasetCalibration calibrate_dataset(const Dataset& dataset, const DatasetOptions& options);

/// The candidate to take: held-out robust error, a richer one only where it wins clearly.
std::size_t choose_by_heldout(const std::vector<CandidateResult>& candidates, double least_improvement);

/// People's text and, for `out_file`, JSON.
void print_calibration(const Dataset& dataset, const DatasetCalibration& result, std::ostream& out);
std::string calibration_json(const Dataset& dataset, const DatasetCalibration& result);

/// The verb: reads, solves, prints, writes JSON to out_file (none if empty). 0 done, 1 refused; throws ConfigError.
int run_calibrate_dataset(const std::filesystem::path& folder, const std::filesystem::path& out_file,
                          std::ostream& out);

}  // namespace armsight::host
