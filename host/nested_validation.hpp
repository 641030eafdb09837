// How well does Learn as a whole predict looks it never saw? Everything is made anew inside each training part: start,
// outliers, noise floor, clock offset and the choice of blocks, which has its own folds within (calibration.md §4.4).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/learn_dataset.hpp"

namespace armsight::host {

struct NestedOptions {
  int fold_seeds = 10;
  LearnCost cost = LearnCost::kLikelihood;
  std::vector<std::string> left_out;           ///< labels of looks that are not counted, nor learnt from
  std::optional<std::vector<ModelBlock>> blocks;  ///< these, without a choice; else what each training part calls for
};

struct NestedResult {
  ErrorStatistics heldout;                     ///< medians over the splits
  std::map<std::string, int> chosen;           ///< how many training parts chose which blocks
};

/// Splits run on all cores; the result does not depend on how many there are.
NestedResult validate_learn(const Dataset& dataset, const NestedOptions& options);

}  // namespace armsight::host
