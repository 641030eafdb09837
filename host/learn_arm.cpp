// The default arm's Learn: looks → host/chain_problem.hpp → solution → verdict (learn_arm_verdict.cpp).
#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "host/learn_arm_verdict.hpp"
#include "host/model_blocks.hpp"
#include "host/observability.hpp"

namespace armsight::host {
namespace {

ChainModel arm_problem(const ArmModel& arm, const CalibrationOptions& options) {
  ChainModel model;
  ProblemChain chain{"arm", arm.chain, {}, false};
  for (int j = 0; j < arm.joint_count(); ++j) {
    chain.joints.push_back(j);
    const bool is_free = options.with_offsets && j > 0;  // beta_1 is held at 0: the gauge goes to the base (§5.3)
    model.offsets.push_back({joint_name(options, j), 0.0, is_free ? Freedom::kPrior : Freedom::kFixed, 0.0,
                             kOffsetPriorSigma_rad});
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
    observations.push_back(z);
  }
  return observations_for(options.cost, {}, observations);
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

void fill_looks(const BatchSolution& solution, ArmCalibration& result) {
  for (std::size_t i = 0; i < solution.looks.size(); ++i) {
    const Vector6 e =
        pose_error(solution.observations[i].T_C_M, predicted_T_C_M(solution.model, solution.observations[i]));
    const LookFit& look = solution.looks[i];
    result.looks.push_back({look.used, look.second_solution, look.reason, 1e3 * e.head<3>().norm(),
                            e.tail<3>().norm() / kDegree});
  }
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
  result.why = reason_to_refuse(looks, solution, options, result);
  if (!result.why.empty()) return result;

  const auto heldout = cross_validate(problem, used, batch, options.folds, options.fold_seed);
  result.heldout = rms_of(heldout);
  judge_against_previous(solution, batch.noise, heldout, options, result);
  return result;
}

}  // namespace armsight::host
