// Two streams in two clocks: where was the arm when that look was made, and how far do the clocks stand apart?
// t_arm = t_look + offset. The offset is the one at which the looks fit the arm best, by the same robust cost as Learn.
#pragma once

#include <vector>

#include "host/batch_calibration.hpp"
#include "host/dataset.hpp"

namespace armsight::host {

/// Arm posture at a time of the arm's clock: linear between stamps, slerp for given poses; false outside the stream.
bool posture_at(const ArmStream& stream, double time_s, Observation& z);

/// The looks of a two-stream set with the posture of their time; those outside the stream go to left_out.
std::vector<Observation> looks_at_offset(const Dataset& dataset, double offset_s, std::vector<LeftOut>* left_out);

/// Offset within ±dataset.max_offset_s, to 0.1 ms: a coarse sweep, then golden section.
double estimate_time_offset_s(const Dataset& dataset, const BatchOptions& options);

}  // namespace armsight::host
