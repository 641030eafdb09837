// One robust least-squares solve of the batch calibration: what batch_calibration.cpp calls, round by round.
#pragma once

#include "host/batch_calibration.hpp"

namespace armsight::host {

struct Refined {
  ChainModel model;
  int iterations = 0;
  bool converged = false;
};

/// Levenberg-Marquardt from `model` over the observations marked used; `width` of the loss in whitened norms a row.
Refined refine(const ChainModel& model, const std::vector<Observation>& observations, const std::vector<char>& used,
               const BatchOptions& options, double width);

/// The same by Ceres (DENSE_QR) to its tightest tolerances: for comparison.
Refined refine_by_ceres(const ChainModel& model, const std::vector<Observation>& observations,
                        const std::vector<char>& used, const BatchOptions& options, double width);

}  // namespace armsight::host
