// May this calibration be used? What speaks against it in words that say what to do (E2, F-C5), and whether it beats
// the model in force on looks it never saw (F-C8). Internal to learn_arm.cpp.
#pragma once

#include <string>
#include <vector>

#include "host/cross_validation.hpp"
#include "host/learn_arm.hpp"

namespace armsight::host {

std::string joint_name(const CalibrationOptions& options, int joint);
std::vector<Observation> used_only(const BatchSolution& solution);
PoseErrorRms rms_of(const ErrorStatistics& s);

/// All but the gauge of beta_1 are seen.
bool is_rank_complete(const ArmCalibration& result, const CalibrationOptions& options);

/// Empty for none; in the order of how much each reason explains.
std::string reason_to_refuse(const std::vector<LookSample>& looks, const BatchSolution& solution,
                             const CalibrationOptions& options, const ArmCalibration& result);

/// Accepts, unless the model in force has the lower held-out error on the same looks; says both figures.
void judge_against_previous(const BatchSolution& solution, const NoiseModel& noise, const ErrorStatistics& heldout,
                            const CalibrationOptions& options, ArmCalibration& result);

}  // namespace armsight::host
