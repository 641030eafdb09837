// What can these looks not tell? Rank and null space of the whitened Jacobian, in words, and σ of every unknown;
// specification §5.3, calibration.md §3. The null space is stated, never hidden: an offset that cannot be told apart
// is held, and said to be held.
#pragma once

#include <string>
#include <vector>

#include "host/look_weight.hpp"

namespace armsight::host {

struct Observability {
  int parameters = 0, rank = 0;
  double condition = 0.0;              ///< of the column-scaled Jacobian, null space left out
  std::vector<Eigen::VectorXd> null_vectors;  ///< each with its own pivot unknown at 1 (an offset where one takes part)
  std::vector<int> pivot_columns;      ///< the column of that unknown
  std::vector<std::string> sentences;  ///< one a null vector
};

/// Of all unknowns that are not fixed, at this model; priors left out: what the looks alone say.
Observability observe(const ChainModel& model, const std::vector<Observation>& observations,
                      const std::vector<char>& used, const NoiseModel& noise);

/// Fixes the offsets that are pivots of null vectors until none is left or only mounts remain; names the sentences
/// of what was held. The offset held is the joint nearest to a mount.
std::vector<std::string> hold_unobservable_offsets(ChainModel& model, const std::vector<Observation>& observations,
                                                   const std::vector<char>& used, const NoiseModel& noise);

/// (JᵀJ)⁻¹ of the unknowns not fixed, priors included; infinite diagonal where singular.
Eigen::MatrixXd covariance_of(const ChainModel& model, const std::vector<Observation>& observations,
                              const std::vector<char>& used, const NoiseModel& noise);

}  // namespace armsight::host
