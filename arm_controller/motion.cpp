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

}  // namespace

Motion::Motion(const RobotConfig& robot)
    : chain_(robot.arm.chain), limits_(robot.arm.limits), period_s_(robot.controller.period_s),
      goal_tolerance_rad_(robot.controller.goal_tolerance_rad), servo_(robot.arm.limits),
      trim_(JointVector::Zero(chain_.joint_count)), target_reading_(JointVector::Zero(chain_.joint_count)) {
  servo_.reset(JointVector::Zero(chain_.joint_count));
}

void Motion::reading_limits(const JointLimits& limits, const JointVector& beta, JointVector& min_rad,
                            JointVector& max_rad) noexcept {
  min_rad = limits.min_rad.cwiseMax(limits.min_rad - beta);
  max_rad = limits.max_rad.cwiseMin(limits.max_rad - beta);
}

void Motion::stand_at(const JointVector& q_reading) noexcept {
  servo_.reset(q_reading);
  trim_.setZero();
}

void Motion::start(const Goal& goal, const LearnedModel& model) noexcept {
  goal_ = goal;
  target_reading_ = goal.q_real_rad - model.beta;
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

void Motion::model_changed(const LearnedModel& model) noexcept {
  if (goal_.kind == GoalKind::kPoseInCamera) {
    T_B_G_ = model.T_C_B.inverse() * T_C_G_;
    T_B_reachable_ = model.T_C_B.inverse() * T_C_reachable_;
  }
  if (goal_.kind != GoalKind::kJoints && phase_ == Phase::kSettle) enter(Phase::kApproach);
}

void Motion::enter(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0.0;
}

Progress Motion::step_to_goal(const LearnedModel& model, const StillnessWatch& measured) noexcept {
  phase_s_ += period_s_;
  switch (phase_) {
    case Phase::kTravel: step_travel(); return Progress::kMoving;
    case Phase::kApproach: step_approach(model); return Progress::kMoving;
    case Phase::kSettle: break;
  }
  return step_settle(model, measured);
}

void Motion::step_to_rest() noexcept { servo_.step_to_rest(period_s_); }

void Motion::step_travel() noexcept {
  const JointSetpoint& s = servo_.step_towards(target_reading_, goal_.speed_scale, period_s_);
  const bool is_there = (s.q_rad - target_reading_).cwiseAbs().maxCoeff() < kAtPosture_rad;
  if (!is_there || !servo_.is_at_rest()) return;
  enter(goal_.kind == GoalKind::kJoints ? Phase::kSettle : Phase::kApproach);
}

void Motion::step_approach(const LearnedModel& model) noexcept {
  JointVector min_rad, max_rad;
  reading_limits(limits_, model.beta, min_rad, max_rad);
  min_rad += model.beta;
  max_rad += model.beta;
  const JointVector max_speed = goal_.speed_scale * limits_.max_speed_rad_s;
  const JointVector speeds = pose_servo_speeds(chain_, servo_.setpoint().q_rad + model.beta, T_B_reachable_, min_rad,
                                               max_rad, max_speed, period_s_, pose_options_);
  servo_.step_with_speed(speeds, period_s_);
  if (speeds.cwiseAbs().maxCoeff() < kNoSpeed_rad_s || phase_s_ > kApproachTimeout_s) enter(Phase::kSettle);
}

Progress Motion::step_settle(const LearnedModel& model, const StillnessWatch& measured) noexcept {
  servo_.step_to_rest(period_s_);
  if (!servo_.is_at_rest() || !measured.is_still()) {
    if (phase_s_ > kSettleTimeout_s) return Progress::kGivenUp;
    return Progress::kMoving;
  }
  const JointVector residual = servo_.setpoint().q_rad - measured.mean_rad();
  const bool is_trimmed = residual.cwiseAbs().maxCoeff() < kTrimmed_rad;
  if (is_trimmed || phase_s_ > kTrimTimeout_s) {
    if (is_within_tolerance(model, measured.mean_rad())) return Progress::kArrived;
    if (phase_s_ > kSettleTimeout_s) return Progress::kGivenUp;
  }
  trim_ += kTrimGain_per_s * period_s_ * residual;
  trim_ = trim_.cwiseMax(-kTrimLimit_rad).cwiseMin(kTrimLimit_rad);
  return Progress::kMoving;
}

bool Motion::is_within_tolerance(const LearnedModel& model, const JointVector& q_reading) const noexcept {
  if (goal_.kind == GoalKind::kJoints)
    return (q_reading - target_reading_).cwiseAbs().maxCoeff() <= goal_tolerance_rad_;
  double position_m, orientation_rad;
  errors_at(q_reading, model, position_m, orientation_rad);
  return position_m <= goal_.position_tolerance_m && orientation_rad <= goal_.orientation_tolerance_rad;
}

JointVector Motion::command_rad() const noexcept {
  const JointVector& q = servo_.setpoint().q_rad;
  return (q + trim_).cwiseMax(limits_.min_rad.cwiseMin(q)).cwiseMin(limits_.max_rad.cwiseMax(q));
}

void Motion::errors_at(const JointVector& q_reading, const LearnedModel& model, double& position_m,
                       double& orientation_rad) const noexcept {
  const Vector6 e = pose_error(forward_kinematics(chain_, q_reading + model.beta), T_B_G_);
  position_m = e.head<3>().norm();
  orientation_rad = e.tail<3>().norm();
}

}  // namespace armsight::arm
