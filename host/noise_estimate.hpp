// How noisy are these looks really? What a data set states of its noise is a guess; the residuals know better. Each
// look tells by how much its pose is off and what its own corners allow; the floor is what makes the rest likely, by a
// t-likelihood of few freedoms, so that outliers do not widen it.
#pragma once

#include "host/look_weight.hpp"

namespace armsight::host {

/// `given` with its floor replaced by the one that the looks marked used ask for at this model.
NoiseModel estimated_floor(const ChainModel& model, const std::vector<Observation>& observations,
                           const std::vector<char>& used, const NoiseModel& given);

/// σ_px of the looks with corners: what remains of a typical look once its pose is its own. 0: no look has corners.
double estimated_sigma_px(const ChainModel& model, const std::vector<Observation>& observations,
                          const std::vector<char>& used);

}  // namespace armsight::host
