#include "host/learn_arm_verdict.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace armsight::host {
namespace {

/// Which joint moved least over the used looks, and how much.
std::pair<int, double> laziest_joint(const std::vector<LookSample>& looks, const std::vector<char>& used) {
  std::pair<int, double> least{0, std::numeric_limits<double>::infinity()};
  for (int j = 0; j < looks[0].q_reading.size(); ++j) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < looks.size(); ++i) {
      if (!used[i]) continue;
      low = std::min(low, looks[i].q_reading[j]);
      high = std::max(high, looks[i].q_reading[j]);
    }
    if (high - low < least.second) least = {j, high - low};
  }
  return least;
}

std::string advice(const std::vector<LookSample>& looks, const std::vector<char>& used,
                   const CalibrationOptions& options) {
  const auto [joint, range] = laziest_joint(looks, used);
  if (range > 40 * kDegree) return "add looks in other postures";
  char text[200];
  std::snprintf(text, sizeof text, "%s moved only %.0f deg: add looks with it spread over at least 40 deg",
                joint_name(options, joint).c_str(), range / kDegree);
  return text;
}

int expected_rank(const ArmCalibration& result, const CalibrationOptions& options) {
  return result.parameters - (options.with_offsets ? 1 : 0);  // the gauge of beta_1
}
ChainModel with_learned(const ChainModel& model, const LearnedModel& learned) {
  ChainModel other = model;
  other.T_C_a.value = learned.T_C_B;
  for (int j = 0; j < learned.beta.size(); ++j) other.offsets[static_cast<std::size_t>(j)].value = learned.beta[j];
  return other;
}

}  // namespace

std::string joint_name(const CalibrationOptions& options, int joint) {
  const auto index = static_cast<std::size_t>(joint);
  return index < options.joint_names.size() ? options.joint_names[index] : "joint " + std::to_string(joint + 1);
}

std::vector<Observation> used_only(const BatchSolution& solution) {
  std::vector<Observation> used;
  for (std::size_t i = 0; i < solution.observations.size(); ++i) {
    if (solution.used[i]) used.push_back(solution.observations[i]);
  }
  return used;
}

PoseErrorRms rms_of(const ErrorStatistics& s) { return {s.rms_mm, s.rms_deg}; }

bool is_rank_complete(const ArmCalibration& result, const CalibrationOptions& options) {
  return result.rank >= expected_rank(result, options);
}

std::string reason_to_refuse(const std::vector<LookSample>& looks, const BatchSolution& solution,
                    const CalibrationOptions& options, const ArmCalibration& result) {
  char text[240];
  const auto used = std::count(solution.used.begin(), solution.used.end(), char{1});
  if (used < options.min_looks || 3 * used < 2 * static_cast<std::ptrdiff_t>(looks.size())) {
    std::snprintf(text, sizeof text, "only %td of %zu looks agree with each other: did the camera move, is the marker's"
                  " size or place wrong?", used, looks.size());
    return text;
  }
  if (!is_rank_complete(result, options)) {
    return "rank " + std::to_string(result.rank) + " of " + std::to_string(expected_rank(result, options)) +
           " that are possible: " +
           (result.unobservable.empty() ? "" : result.unobservable.back() + "; ") +
           advice(looks, solution.used, options);
  }
  if (options.cost == LearnCost::kLikelihood && solution.misfit > options.max_misfit) {
    std::snprintf(text, sizeof text,
                  "the looks contradict each other: %.1f times their expected noise remains (at most"
                  " %.1f): did the camera move, is the marker's size or place wrong?",
                  solution.misfit, options.max_misfit);
    return text;
  }
  const bool has_sigma = options.with_offsets && options.cost == LearnCost::kLikelihood;
  for (int j = 1; has_sigma && j < result.beta_sigma_rad.size(); ++j) {
    if (result.beta_sigma_rad[j] <= options.max_beta_sigma_rad) continue;
    std::snprintf(text, sizeof text, "the offset of %s is only known to %.1f deg (at most %.1f); ",
                  joint_name(options, j).c_str(), result.beta_sigma_rad[j] / kDegree,
                  options.max_beta_sigma_rad / kDegree);
    return text + advice(looks, solution.used, options);
  }
  return {};
}

void judge_against_previous(const BatchSolution& solution, const NoiseModel& noise, const ErrorStatistics& heldout,
                            const CalibrationOptions& options, ArmCalibration& result) {
  result.accepted = true;
  char text[200];
  std::snprintf(text, sizeof text, "held-out %.2f mm, %.2f deg", heldout.rms_mm, heldout.rms_deg);
  result.why = text;
  if (!options.previous || options.previous->beta.size() != result.model.beta.size()) return;
  const auto old_errors = evaluate(with_learned(solution.model, *options.previous), used_only(solution), noise);
  result.previous = rms_of(old_errors);
  result.accepted = heldout.robust_norm < old_errors.robust_norm;
  std::snprintf(text, sizeof text, "%s: held-out %.2f mm, %.2f deg; the model in force does %.2f mm, %.2f deg on the"
                " same looks", result.accepted ? "better than the model in force" : "no better than the model in force",
                heldout.rms_mm, heldout.rms_deg, old_errors.rms_mm, old_errors.rms_deg);
  result.why = text;
}

}  // namespace armsight::host
