// Two streams in two clocks: where was the arm when that look was made, and how far do the clocks stand apart?
// t_arm = t_look + offset. The offset is the one at which the looks fit the arm best, by the same robust cost as Learn.
#pragma once

#include <vector>

#include "host/batch_calibration.hpp"
#include "host/dataset.hpp"

namespace armsight::host {

/// Arm posture at a time of the arm's clock and how fast it moves there: linear between stamps, slerp for given poses;
/// false outside the stream.
bool posture_at(const ArmStream& stream, double time_s, Observation& z);

/// The looks of a two-stream set with the posture of their time; those outside the stream go to left_out.
std::vector<Observation> looks_at_offset(const Dataset& dataset, double offset_s, std::vector<LeftOut>* left_out);

/// Without the looks made where the arm stood still since the last one kept: they share its errors, and a long stop
/// must not weigh as much as many places.
Dataset without_repeats(const Dataset& dataset);

struct TimeOffset {
  double offset_s = 0.0, sigma_s = 0.0;
};
/// Offset within ±dataset.max_offset_s: a coarse sweep, then an unknown of the batch solution beside the mounts.
/// Throws ConfigError where the streams overlap too little.
TimeOffset estimate_time_offset(const Dataset& dataset, const BatchOptions& options);

}  // namespace armsight::host
