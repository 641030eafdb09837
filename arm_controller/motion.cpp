#include "arm_controller/motion.hpp"

#include <algorithm>

namespace armsight::arm {
namespace {

constexpr double kAtPosture_rad = 1e-4;
constexpr double kNoSpeed_rad_s = 5e-4;
constexpr double kApproachTimeout_s = 3.0;
constexpr double kTrimGain_per_s = 6.0;       ///< well below the window's lag of 60 ms
constexpr double kTrimLimit_rad = 0.02;       ///< ten times the residual of specification §7.1: no wind-up
constexpr double kTrimmed_rad = 4e-4;         ///< 0.02°: the encoder's jitter
constexpr double kTrimTimeout_s = 1.5;
constexpr double kSettleTimeout_s = 3.0;
constexpr int kLooksAhead = 8;                ///< along a stop of at most 0.3 s

}  // namespace

Motion::Motion(const RobotConfig& robot)
    : chain_(robot.arm.chain), file_limits_(robot.arm.limits), limits_(robot.arm.limits), commissioning_(robot),
      period_s_(robot.controller.period_s), goal_tolerance_rad_(robot.controller.goal_tolerance_rad),
      servo_(robot.arm.limits), before_(servo_),
      collision_(commissioning_.is_done() ? robot.collision.model : CollisionModel{}),  // angles that mean nothing yet
      levers_m_(levers_m(collision_, chain_)),
      trim_(JointVector::Zero(chain_.joint_count)), target_reading_(JointVector::Zero(chain_.joint_count)),
      wanted_reading_(JointVector::Zero(chain_.joint_count)),
      seen_rad_(JointVector::Zero(chain_.joint_count)) {
  seen_.distance_m = -1.0;  // nothing was looked at yet
  goal_.q_real_rad = JointVector::Zero(chain_.joint_count);
}

void Motion::reading_limits(const JointLimits& limits, const JointVector& beta, JointVector& min_rad,
                            JointVector& max_rad) noexcept {
  min_rad = limits.min_rad.cwiseMax(limits.min_rad - beta);
  max_rad = limits.max_rad.cwiseMin(limits.max_rad - beta);
}

void Motion::stand_at(const JointVector& q_reading) noexcept {
  servo_.reset(q_reading);
  trim_.setZero();
  yield_rad_.reset();
  if (commissioning_.is_done()) return;
  limits_ = commissioning_.limits_at(file_limits_, q_reading);
  servo_.set_limits(limits_);
}

void Motion::start(const Goal& goal, const LearnedModel& model) noexcept {
  goal_ = goal;
  yield_rad_.reset();
  take_model(model);
  const Pose T_B_posture = forward_kinematics(chain_, goal.q_real_rad);
  if (goal.kind == GoalKind::kJoints) {
    T_B_G_ = T_B_reachable_ = T_B_posture;
  } else {
    T_B_G_ = goal.kind == GoalKind::kPoseInBase ? goal.T_X_G : model.T_C_B.inverse() * goal.T_X_G;
    T_B_reachable_ = {T_B_posture.R, T_B_G_.p};
    T_C_G_ = model.T_C_B * T_B_G_;
    T_C_reachable_ = model.T_C_B * T_B_reachable_;
  }
  enter(Phase::kTravel);
}

void Motion::take_model(const LearnedModel& model) noexcept {
  target_reading_ = goal_.q_real_rad - model.beta;
  JointLimits limits = limits_;
  reading_limits(limits_, model.beta, limits.min_rad, limits.max_rad);
  limits.max_rad = limits.max_rad.cwiseMax(limits.min_rad);
  servo_.set_limits(limits);
}

// Only what is aimed at changes: the servo goes there inside its limits, from whatever motion it is in.
void Motion::model_changed(const LearnedModel& model) noexcept {
  take_model(model);
  if (goal_.kind == GoalKind::kPoseInCamera) {
    T_B_G_ = model.T_C_B.inverse() * T_C_G_;
    T_B_reachable_ = model.T_C_B.inverse() * T_C_reachable_;
  }
  const bool is_settling = phase_ == Phase::kSettle || phase_ == Phase::kTrim;
  if (is_settling) enter(goal_.kind == GoalKind::kJoints ? Phase::kTravel : Phase::kApproach);
}

void Motion::enter(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0.0;
}

Progress Motion::step_to_goal(const LearnedModel& model, const StillnessWatch& measured) noexcept {
  phase_s_ += period_s_;
  before_ = servo_;
  switch (phase_) {
    case Phase::kTravel: step_travel(); break;
    case Phase::kApproach: step_approach(model); break;
    case Phase::kSettle: return step_settle(measured);
    case Phase::kTrim: return step_trim(model, measured);
  }
  return Progress::kMoving;
}

void Motion::step_to_rest() noexcept {
  if (!yield_rad_) {
    servo_.step_to_rest(period_s_);
    return;
  }
  const JointVector target = yield_rad_->cwiseMax(servo_.limits().min_rad).cwiseMin(servo_.limits().max_rad);
  servo_.step_towards(target, 1.0, period_s_);
  if (servo_.is_at_rest() && servo_.setpoint().q_rad == target) yield_rad_.reset();
}

// Where the arm was last looked at is remembered: while no stop can lead from there to the margin, no look is needed.
std::optional<Clearance> Motion::too_near_ahead(const LearnedModel& model) noexcept {
  if (collision_.is_empty() || servo_.is_at_rest()) return std::nullopt;
  if (is_free_of(seen_rad_, seen_.distance_m, model)) return std::nullopt;
  seen_rad_ = command_rad() + model.beta;
  seen_ = clearance_at(collision_, chain_, seen_rad_);
  if (is_free_of(seen_rad_, seen_.distance_m, model)) return std::nullopt;
  Clearance nearest;
  for (int k = kLooksAhead; k > 0; --k) {
    const double part = static_cast<double>(k) / kLooksAhead;
    const Clearance there = clearance_at(collision_, chain_, servo_.stopping_rad(part) + model.beta);
    if (there.distance_m < nearest.distance_m) nearest = there;
  }
  if (nearest.distance_m >= collision_.margin_m || nearest.distance_m >= seen_.distance_m - kNoNearer_m)
    return std::nullopt;
  return nearest;
}

bool Motion::is_free_of(const JointVector& q_real, double distance_m, const LearnedModel& model) const noexcept {
  const double way_m = levers_m_.dot(servo_.stopping_excursion_rad(q_real - model.beta));
  return distance_m - way_m >= collision_.margin_m;
}

void Motion::step_travel() noexcept {
  const JointLimits& limits = servo_.limits();
  const JointVector target = (target_reading_ + trim_).cwiseMax(limits.min_rad).cwiseMin(limits.max_rad);
  servo_.step_towards(target, goal_.speed_scale, period_s_);
  if (!servo_.is_at_rest() || servo_.setpoint().q_rad != target) return;
  enter(goal_.kind == GoalKind::kJoints ? Phase::kSettle : Phase::kApproach);
}

void Motion::step_approach(const LearnedModel& model) noexcept {
  const JointVector min_rad = servo_.limits().min_rad + model.beta, max_rad = servo_.limits().max_rad + model.beta;
  const JointVector max_speed = goal_.speed_scale * limits_.max_speed_rad_s;
  const JointVector q_real = servo_.setpoint().q_rad - trim_ + model.beta;
  const JointVector speeds = pose_servo_speeds(chain_, q_real, T_B_reachable_, min_rad, max_rad, max_speed, period_s_,
                                               pose_options_);
  servo_.step_with_speed(speeds, period_s_);
  if (speeds.cwiseAbs().maxCoeff() < kNoSpeed_rad_s || phase_s_ > kApproachTimeout_s) enter(Phase::kSettle);
}

Progress Motion::step_settle(const StillnessWatch& measured) noexcept {
  servo_.step_to_rest(period_s_);
  if (servo_.is_at_rest() && measured.is_still()) {
    wanted_reading_ = servo_.setpoint().q_rad - trim_;
    enter(Phase::kTrim);
  }
  return phase_s_ > kSettleTimeout_s ? Progress::kGivenUp : Progress::kMoving;
}

Progress Motion::step_trim(const LearnedModel& model, const StillnessWatch& measured) noexcept {
  const JointVector residual = wanted_reading_ - measured.mean_rad();
  const bool is_trimmed = residual.cwiseAbs().maxCoeff() < kTrimmed_rad || phase_s_ > kTrimTimeout_s;
  if (is_trimmed && servo_.is_at_rest() && measured.is_still() && is_within_tolerance(model, measured.mean_rad()))
    return Progress::kArrived;
  if (phase_s_ > kSettleTimeout_s) return Progress::kGivenUp;
  const JointVector room_up = (kTrimLimit_rad - trim_.array()).max(0.0);
  const JointVector room_down = (-kTrimLimit_rad - trim_.array()).min(0.0);
  const JointVector speeds = kTrimGain_per_s * residual.cwiseMin(room_up).cwiseMax(room_down);
  if (is_trimmed) servo_.step_to_rest(period_s_);
  else servo_.step_with_speed(speeds, period_s_);
  trim_ = servo_.setpoint().q_rad - wanted_reading_;
  return Progress::kMoving;
}

bool Motion::is_within_tolerance(const LearnedModel& model, const JointVector& q_reading) const noexcept {
  if (goal_.kind == GoalKind::kJoints)
    return (q_reading - target_reading_).cwiseAbs().maxCoeff() <= goal_tolerance_rad_;
  double position_m, orientation_rad;
  errors_at(q_reading, model, position_m, orientation_rad);
  return position_m <= goal_.position_tolerance_m && orientation_rad <= goal_.orientation_tolerance_rad;
}

void Motion::errors_at(const JointVector& q_reading, const LearnedModel& model, double& position_m,
                       double& orientation_rad) const noexcept {
  const Vector6 e = pose_error(forward_kinematics(chain_, q_reading + model.beta), T_B_G_);
  position_m = e.head<3>().norm();
  orientation_rad = e.tail<3>().norm();
}

}  // namespace armsight::arm
