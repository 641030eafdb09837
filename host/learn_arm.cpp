// The default arm's Learn: looks → host/chain_problem.hpp → verdict. See host/learn_arm.hpp.
#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "host/learn_arm.hpp"
#include "host/cross_validation.hpp"
#include "host/observability.hpp"

namespace armsight::host {
namespace {


std::string joint_name(const CalibrationOptions& options, int joint) {
  const auto index = static_cast<std::size_t>(joint);
  return index < options.joint_names.size() ? options.joint_names[index] : "joint " + std::to_string(joint + 1);
}

ChainModel arm_problem(const ArmModel& arm, const CalibrationOptions& options) {
  ChainModel model;
  ProblemChain chain{"arm", arm.chain, {}, false};
  for (int j = 0; j < arm.joint_count(); ++j) {
    chain.joints.push_back(j);
    const bool is_free = options.with_offsets && j > 0;  // beta_1 is held at 0: the gauge goes to the base (§5.3)
    model.offsets.push_back({joint_name(options, j), 0.0, is_free ? Freedom::kFree : Freedom::kFixed, 0.0, 0.0});
  }
  model.chains.push_back(chain);
  model.T_C_a.name = "the base";
  ProblemTarget hand;
  hand.name = "hand";
  hand.chain = 0;
  hand.T_b_M.name = "the marker mount";
  hand.T_b_M.freedom = Freedom::kFixed;  // the looks are hand poses already
  model.targets.push_back(hand);
  return model;
}

std::vector<Observation> arm_observations(const std::vector<LookSample>& looks, const CalibrationOptions& options) {
  std::vector<Observation> observations;
  for (const auto& look : looks) {
    Observation z;
    z.q = look.q_reading;
    z.T_C_M = look.T_C_H;
    z.T_C_M_second = look.T_C_H_second;
    z.R_vision = look.R_vision.selfadjointView<Eigen::Upper>();  // what a saved look holds of it, to the last bit
    if (options.cost == LearnCost::kThesis) {  // (4.6): e_O is the half angle, 1 m ≙ 2 rad; scaled to our floor
      const double s = options.floor_position_sigma_m;
      z.R_vision = (Vector6() << s * s, s * s, s * s, 4 * s * s, 4 * s * s, 4 * s * s).finished().asDiagonal();
    }
    observations.push_back(z);
  }
  return observations;
}

BatchOptions batch_options(const CalibrationOptions& options) {
  BatchOptions batch;
  if (options.cost == LearnCost::kThesis) {
    batch.loss = RobustLoss::kNone;
    return batch;
  }
  batch.noise = {options.encoder_sigma_rad, options.floor_position_sigma_m, options.floor_rotation_sigma_rad};
  return batch;
}

/// Nonsense that must not reach the solver; empty when the looks are sound.
std::string broken_input(const ArmModel& arm, const std::vector<LookSample>& looks, const CalibrationOptions& options) {
  const auto least = static_cast<std::size_t>(std::max(options.min_looks, 2));
  if (looks.size() < least) {
    return std::to_string(looks.size()) + " looks: at least " + std::to_string(least) + " are needed; add looks";
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const auto& look = looks[i];
    const std::string where = "look " + std::to_string(i + 1) + ": ";
    if (look.q_reading.size() != arm.joint_count()) return where + "has not one reading a joint";
    if (!look.q_reading.allFinite() || !is_finite(look.T_C_H) || !look.R_vision.allFinite()) {
      return where + "holds a number that is not finite";
    }
    if (!is_rotation(look.T_C_H.R, 1e-4)) return where + "its rotation is none";
  }
  return {};
}

PoseErrorRms rms_of(const ErrorStatistics& s) { return {s.rms_mm, s.rms_deg}; }

void fill_looks(const BatchSolution& solution, ArmCalibration& result) {
  for (std::size_t i = 0; i < solution.looks.size(); ++i) {
    const Vector6 e = pose_error(solution.observations[i].T_C_M, predicted_T_C_M(solution.model, solution.observations[i]));
    const LookFit& look = solution.looks[i];
    result.looks.push_back({look.used, look.second_solution, look.reason, 1e3 * e.head<3>().norm(),
                            e.tail<3>().norm() / kDegree});
  }
}

std::vector<Observation> used_only(const BatchSolution& solution) {
  std::vector<Observation> used;
  for (std::size_t i = 0; i < solution.observations.size(); ++i) {
    if (solution.used[i]) used.push_back(solution.observations[i]);
  }
  return used;
}

/// All offsets free, to see the gauge; then beta_1 fixed, for σ and condition.
void fill_observability(const BatchSolution& solution, const NoiseModel& noise, const CalibrationOptions& options,
                        ArmCalibration& result) {
  ChainModel all_free = solution.model;
  for (auto& offset : all_free.offsets) offset.freedom = options.with_offsets ? Freedom::kFree : Freedom::kFixed;
  const Observability seen = observe(all_free, solution.observations, solution.used, noise);
  result.rank = seen.rank;
  result.parameters = seen.parameters;
  result.condition = seen.condition;
  if (seen.null_vectors.size() == 1) result.null_vector = -seen.null_vectors[0];
  ChainModel held = all_free;
  result.unobservable = hold_unobservable_offsets(held, solution.observations, solution.used, noise);
}

void fill_covariance(const BatchSolution& solution, const NoiseModel& noise, const CalibrationOptions& options,
                     ArmCalibration& result) {
  const int n = static_cast<int>(solution.model.offsets.size());
  ChainModel free_model = solution.model;
  result.beta_sigma_rad.setConstant(n, std::numeric_limits<double>::infinity());
  const Eigen::MatrixXd held = covariance_of(free_model, solution.observations, solution.used, noise);
  result.camera_sigma_m = std::sqrt(held.diagonal().head<3>().sum());
  result.camera_sigma_rad = std::sqrt(held.diagonal().segment<3>(3).sum());
  for (int k = 6; k < held.rows(); ++k) result.beta_sigma_rad[k - 5] = std::sqrt(held(k, k));  // beta_2 … beta_n

  for (auto& offset : free_model.offsets) offset.freedom = Freedom::kFree;
  free_model.offsets[0].freedom = Freedom::kPrior;
  free_model.offsets[0].prior_sigma = options.beta1_sigma_rad;
  result.covariance = covariance_of(free_model, solution.observations, solution.used, noise);
}

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
bool is_rank_complete(const ArmCalibration& result, const CalibrationOptions& options) {
  return result.rank >= expected_rank(result, options);
}

/// The reason to refuse, empty for none; in the order of how much each explains.
std::string refusal(const std::vector<LookSample>& looks, const BatchSolution& solution,
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
  if (options.cost == LearnCost::kWhitened && solution.misfit > options.max_misfit) {
    std::snprintf(text, sizeof text, "the looks contradict each other: %.1f times their expected noise remains (at most"
                  " %.1f): did the camera move, is the marker's size or place wrong?", solution.misfit, options.max_misfit);
    return text;
  }
  for (int j = 1; options.with_offsets && options.cost == LearnCost::kWhitened && j < result.beta_sigma_rad.size(); ++j) {
    if (result.beta_sigma_rad[j] <= options.max_beta_sigma_rad) continue;
    std::snprintf(text, sizeof text, "the offset of %s is only known to %.1f deg (at most %.1f); ",
                  joint_name(options, j).c_str(), result.beta_sigma_rad[j] / kDegree, options.max_beta_sigma_rad / kDegree);
    return text + advice(looks, solution.used, options);
  }
  return {};
}

ChainModel with_learned(const ChainModel& model, const LearnedModel& learned) {
  ChainModel other = model;
  other.T_C_a.value = learned.T_C_B;
  for (int j = 0; j < learned.beta.size(); ++j) other.offsets[static_cast<std::size_t>(j)].value = learned.beta[j];
  return other;
}

/// F-C8: the held-out error of the new model against the old one's on the same looks.
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

}  // namespace

ArmCalibration calibrate_arm(const ArmModel& arm, const std::vector<LookSample>& looks,
                             const CalibrationOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  ArmCalibration result;
  result.model.beta.setZero(arm.joint_count());
  result.covariance.setZero(6 + arm.joint_count(), 6 + arm.joint_count());
  result.beta_sigma_rad.setConstant(arm.joint_count(), std::numeric_limits<double>::infinity());
  result.why = broken_input(arm, looks, options);
  if (!result.why.empty()) return result;

  const BatchOptions batch = batch_options(options);
  const ChainModel problem = arm_problem(arm, options);
  const BatchSolution solution = learn(problem, arm_observations(looks, options), batch);
  result.solve_wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.model.T_C_B = solution.model.T_C_a.value;
  for (int j = 0; j < arm.joint_count(); ++j) {
    result.model.beta[j] = solution.model.offsets[static_cast<std::size_t>(j)].value;
  }
  fill_looks(solution, result);
  fill_observability(solution, batch.noise, options, result);
  const auto used = used_only(solution);
  result.training = rms_of(evaluate(solution.model, used, batch.noise));
  if (is_rank_complete(result, options)) fill_covariance(solution, batch.noise, options, result);
  result.why = refusal(looks, solution, options, result);
  if (!result.why.empty()) return result;

  const auto heldout = cross_validate(problem, used, batch, options.folds, options.fold_seed);
  result.heldout = rms_of(heldout);
  judge_against_previous(solution, batch.noise, heldout, options, result);
  return result;
}

}  // namespace armsight::host
