#include "arm_controller/adaptation.hpp"

namespace armsight::arm {
Adaptation::Adaptation(const RobotConfig& robot, const StartModel& start)
    : chain_(robot.arm.chain), time_bound_(seconds_to_duration(robot.controller.look_time_bound_s)),
      max_speed_rad_s_(robot.controller.look_max_speed_rad_s), filter_(robot.arm.chain, robot.filter),
      model_(start.model), model_at_begin_(start.model), source_(start.source) {
  if (start.P) filter_.reset(model_, *start.P);
  else filter_.reset(model_);
}

void Adaptation::begin(bool keep_covariance) noexcept {
  if (!keep_covariance) filter_.reset(model_);
  model_at_begin_ = model_;
  is_open_ = true;
}

bool Adaptation::fuse(const HandPoseMeasurement& z, FusionReport& report) noexcept {
  const StateMatrix P_before = filter_.covariance();
  report = filter_.update(z);
  if (report.outcome != FusionOutcome::kFused && report.outcome != FusionOutcome::kFusedSecondSolution) return true;
  if (!is_plausible(filter_.model())) {
    filter_.reset(model_, P_before);
    return false;
  }
  const std::uint64_t revision = model_.revision + 1;
  model_ = filter_.model();
  model_.revision = revision;
  source_ = ModelSource::kFilter;
  return true;
}

AnswerEvent Adaptation::take(const Look& look, const JointHistory& history, FilterEvent& event) noexcept {
  if (!is_open_) return {look.tag, Answer::kWrongState, "no recalibration was started"};
  event = {};
  event.capture_time = look.capture_time;
  event.q_reading_rad = JointVector::Zero(chain_.joint_count);
  const auto joints = history.at(look.capture_time);
  AnswerEvent answer{look.tag, Answer::kAccepted, ""};
  if (look.time_bound > time_bound_ || look.time_bound < Duration::zero()) {
    event.look = LookOutcome::kNoJoints;
    answer = {look.tag, Answer::kTime, "time_bound_ns is beyond controller.look_time_bound_s"};
  } else if (!joints) {
    event.look = LookOutcome::kNoJoints;
    answer = {look.tag, Answer::kTime, "the joint history does not hold arm_capture_time_ns"};
  } else if (joints->speed_rad_s.cwiseAbs().maxCoeff() > max_speed_rad_s_) {
    event.look = LookOutcome::kMoving;
    answer = {look.tag, Answer::kMoving, "a joint moved faster than controller.look_max_speed_rad_s"};
  }
  if (joints) event.q_reading_rad = joints->q_rad;
  if (answer.answer == Answer::kAccepted) {
    HandPoseMeasurement z = look.measurement;
    z.q = joints->q_rad;
    if (!fuse(z, event.report)) {
      event.look = LookOutcome::kImplausible;
      answer = {look.tag, Answer::kImplausible, "the look led to an offset above 20 deg or a camera beyond 5 m"};
    }
  }
  fill(event);
  return answer;
}

void Adaptation::fill(FilterEvent& event) const noexcept {
  const CameraCorrection correction = camera_correction(model_at_begin_.T_C_B, model_.T_C_B);
  event.model_revision = model_.revision;
  event.delta_t_m = correction.delta_t_m;
  event.delta_theta_rad = correction.delta_theta_rad;
  event.delta_beta_rad = model_.beta - model_at_begin_.beta;
  event.hand_sigma = filter_.predicted_hand_covariance(event.q_reading_rad).diagonal().cwiseMax(0.0).cwiseSqrt();
}

AnswerEvent Adaptation::take(const Proposal& proposal) noexcept {
  if (proposal.parent_revision != model_.revision)
    return {proposal.tag, Answer::kStaleModel, "parent_revision is not the revision in force"};
  if (!is_plausible(proposal.model) || (proposal.has_covariance && !is_plausible_covariance(proposal.P)))
    return {proposal.tag, Answer::kImplausible, "an offset above 20 deg, a camera beyond 5 m, or a bad covariance"};
  const std::uint64_t revision = model_.revision + 1;
  model_ = proposal.model;
  model_.revision = revision;
  source_ = ModelSource::kCalibration;
  if (proposal.has_covariance) filter_.reset(model_, proposal.P);
  else filter_.reset(model_);
  is_open_ = false;
  return {proposal.tag, Answer::kAccepted, ""};
}

}  // namespace armsight::arm
