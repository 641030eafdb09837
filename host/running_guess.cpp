#include "host/running_guess.hpp"

#include <cmath>

namespace armsight::host {
namespace {

constexpr double kBetaSigma_rad = 0.08;        // offsets of Learn: uniform up to 8 degrees
constexpr double kPositionSigma_m = 0.08;      // what such offsets do to a camera pose from one look
constexpr double kRotationSigma_rad = 0.25;
constexpr double kGate = 60.0;                 // the wide prior is far from linear
constexpr int kContradictionsToRestart = 2;

EkfOptions widened(EkfOptions options) {
  options.prior_beta_sigma_rad = kBetaSigma_rad;
  options.prior_position_sigma_m = kPositionSigma_m;
  options.prior_rotation_sigma_rad = kRotationSigma_rad;
  options.cost_gate = kGate;
  return options;
}

HandPoseMeasurement measurement_of(const LookSample& sample) {
  HandPoseMeasurement z;
  z.T_C_H = sample.T_C_H;
  z.has_second = sample.T_C_H_second.has_value();
  if (z.has_second) z.T_C_H_second = *sample.T_C_H_second;
  z.R_vision = sample.R_vision;
  z.q = sample.q_reading;
  return z;
}

}  // namespace

RunningGuess::RunningGuess(const ArmModel& arm, const EkfOptions& options)
    : arm_(arm), filter_(arm.chain, widened(options)) {}

void RunningGuess::start_from(const LookSample& sample) {
  LearnedModel model;
  model.beta = JointVector::Zero(arm_.joint_count());
  model.T_C_B = sample.T_C_H * forward_kinematics(arm_.chain, sample.q_reading).inverse();
  filter_.reset(model);
  (void)filter_.update(measurement_of(sample));  // no innovation; P learns what one look leaves open
  is_set_ = true;
  contradictions_ = 0;
}

void RunningGuess::take(const std::vector<LookSample>& samples) {
  if (!is_set_) {
    start_from(samples.back());
    return;
  }
  const FusionReport report = filter_.update(measurement_of(samples.back()));
  const bool is_fused =
      report.outcome == FusionOutcome::kFused || report.outcome == FusionOutcome::kFusedSecondSolution;
  contradictions_ = is_fused ? 0 : contradictions_ + 1;
  if (contradictions_ < kContradictionsToRestart) return;
  start_from(samples.back());
  for (const LookSample& sample : samples) (void)filter_.update(measurement_of(sample));
}

void RunningGuess::take(const ArmCalibration& calibration) {
  filter_.reset(calibration.model, calibration.covariance);
  is_set_ = true;
  contradictions_ = 0;
}

double RunningGuess::hand_position_sigma_m(const JointVector& q_reading) const {
  return std::sqrt(filter_.predicted_hand_covariance(q_reading).topLeftCorner<3, 3>().trace());
}

Pose RunningGuess::predict(const JointVector& q_reading) const {
  return predict_T_C_H(arm_.chain, filter_.model().T_C_B, filter_.model().beta, q_reading);
}

}  // namespace armsight::host
