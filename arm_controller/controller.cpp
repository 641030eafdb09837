#include "arm_controller/controller.hpp"

#include <algorithm>

namespace armsight::arm {
namespace {

constexpr int kLateLimit = 10;  // controller.md §10 no. 11

}  // namespace

Controller::Controller(const RobotConfig& robot, const StartModel& start)
    : arm_(robot.arm), period_s_(robot.controller.period_s), margin_m_(robot.collision.model.margin_m),
      history_(seconds_to_duration(robot.controller.period_s)),
      watch_(robot.arm.joint_count(), robot.controller.still_speed_rad_s, robot.controller.still_time_s,
             robot.controller.period_s),
      motion_(robot), contact_(robot), soft_(robot.soft), stiffness_(robot), hand_(robot.controller.period_s),
      adaptation_(robot, start) {
  output_.command.q_rad = JointVector::Zero(arm_.joint_count());
  // By a wrong sign it would push where it should carry.
  feeds_gravity_ = motion_.commissioning().is_done() && soft_.arm().has_masses() &&
                   std::ranges::any_of(robot.drives, [](const DriveConfig& drive) {
                     return drive.family == DriveFamily::kDamiao;
                   });
}

const TickOutput& Controller::tick(Time now, const JointSamples& joints, const TickInbox& inbox) noexcept {
  output_.event_count = 0;
  output_.command.recover = false;
  if (!announced_start_) announce_model();
  apply(ModeEvent::kStarted);
  take_samples(joints);
  take_faults(now, joints, inbox);
  take_bus_phase(joints);
  take_lease(now, inbox);
  take_inbox(now, inbox);
  adaptation_.predict(period_s_);
  watch_contact(now, joints);
  step_motion(now);
  step_command(joints, now);
  fill_snapshot(joints);
  return output_;
}

void Controller::take_samples(const JointSamples& joints) noexcept {
  hand_.step(joints.hand_closure);
  if (!joints.is_fresh) return;
  watch_.push(joints.q_rad);
  history_.push({joints.time, joints.q_rad, watch_.speed_rad_s()});
  joints_time_ = joints.time;
}

void Controller::take_faults(Time now, const JointSamples& joints, const TickInbox& inbox) noexcept {
  late_in_a_row_ = inbox.is_late ? late_in_a_row_ + 1 : 0;
  if (joints.fault.is_set()) raise(now, joints.fault);
  if (late_in_a_row_ >= kLateLimit) raise(now, {FaultCode::kCycleOverrun});
  if (inbox.model_not_saved) raise(now, {FaultCode::kModelNotSaved});
}

void Controller::raise(Time now, const Fault& fault) noexcept {
  if (fault_.is_set()) return;
  fault_ = fault;
  wants_power_ = false;
  end_goal(GoalState::kStopped, "fault");
  hand_.stop();
  apply(ModeEvent::kFault);
  emit(FaultEvent{fault, now});
}

void Controller::take_bus_phase(const JointSamples& joints) noexcept {
  bus_is_ready_ = joints.phase >= BusPhase::kReady && joints.has_positions;
  if (fault_.is_set()) return;
  if (joints.phase >= BusPhase::kConfiguring) apply(ModeEvent::kNodesSeen);
  if (bus_is_ready_) apply(ModeEvent::kConfigured);
  if (mode_ == Mode::kReady && wants_power_ && joints.phase == BusPhase::kPowered && joints.is_fresh) {
    motion_.stand_at(joints.q_rad);
    hand_.stand_at(joints.hand_closure);
    apply(ModeEvent::kPowered);
  }
}

// The slot keeps the newest lease only: that another session holds it is how an end within one cycle shows.
void Controller::take_lease(Time now, const TickInbox& inbox) noexcept {
  const std::optional<Lease> before = lease_;
  if (inbox.lease) lease_ = inbox.lease;
  if (lease_ && (lease_->session == 0 || now > lease_->until)) lease_.reset();
  if (!before || (lease_ && lease_->session == before->session)) return;
  adaptation_.close();
  Fault cause{inbox.lease && inbox.lease->session == 0 ? inbox.lease->why_free : FaultCode::kLeaseSilent};
  if (cause.code == FaultCode::kLeaseSilent) cause.age_ns = (now - before->heard).count();
  stop(now, cause);
}

void Controller::stop(Time now, const Fault& cause) noexcept {
  const bool is_news = goal_is_active_ || mode_ == Mode::kServo || (mode_ == Mode::kReady && wants_power_);
  if (is_news) emit(StopEvent{cause, now});
  end_goal(GoalState::kStopped, stop_text(cause.code));
  hand_.stop();
  if (mode_ == Mode::kReady) wants_power_ = false;
  apply(ModeEvent::kStop);
}

void Controller::end_goal(GoalState state, const char* text) noexcept {
  if (!goal_is_active_) return;
  goal_is_active_ = false;
  GoalEvent event{goal_, state, 0.0, 0.0, adaptation_.model().revision, joints_time_, watch_.mean_rad(), text};
  motion_.errors_at(event.q_reading_rad, adaptation_.model(), event.position_error_m, event.orientation_error_rad);
  emit(event);
}

void Controller::apply(ModeEvent event) noexcept {
  const Mode before = mode_;
  mode_ = next_mode(mode_, event);
  if (before == Mode::kFault && mode_ == Mode::kRecovering) wants_recover_ = true;
}

// What the samples show is what the last cycle's set-points brought about.
void Controller::watch_contact(Time now, const JointSamples& joints) noexcept {
  if (mode_ != Mode::kServo) return contact_.reset();
  if (!joints.is_fresh) return;
  const auto contact = contact_.step(motion_.command_rad(), joints.q_rad, joints.torque_Nm, adaptation_.model().beta);
  if (!contact) return;
  Fault cause{FaultCode::kContact};
  cause.sub = static_cast<std::uint8_t>(contact->joint + 1);
  cause.detail = contact->is_torque ? 1 : 0;
  cause.value = contact->value;
  cause.limit = contact->limit;
  stop(now, cause);
  motion_.yield_to(joints.q_rad);
  adaptation_.doubt();
  announce_model();
}

void Controller::step_motion(Time now) noexcept {
  switch (mode_) {
    case Mode::kServo: {
      const Progress progress = motion_.step_to_goal(adaptation_.model(), watch_);
      if (progress == Progress::kArrived) {
        end_goal(GoalState::kArrived, "");
        apply(ModeEvent::kArrived);
      } else if (progress == Progress::kGivenUp) {
        stop(now, {FaultCode::kGoalGivenUp});
      } else if (const auto near = motion_.too_near_ahead(adaptation_.model())) {
        motion_.step_back();
        motion_.step_to_rest();
        stop(now, too_near_fault(*near, margin_m_));
      }
      break;
    }
    case Mode::kStopping:
      motion_.step_to_rest();
      if (!motion_.is_at_rest()) break;
      apply(ModeEvent::kStandstill);
      if (!wants_power_) apply(ModeEvent::kPowerOff);  // the drives stopped by themselves and hold
      break;
    case Mode::kHold: motion_.step_to_rest(); break;
    default: break;
  }
}

void Controller::step_command(const JointSamples& joints, Time now) noexcept {
  JointCommand& command = output_.command;
  const bool is_driven = mode_ == Mode::kHold || mode_ == Mode::kServo || mode_ == Mode::kStopping;
  command.q_rad = is_driven ? motion_.command_rad() : joints.q_rad;
  step_stiffness();
  step_soft_joints(joints, is_driven);
  command.hand_closure = hand_.command();
  command.hand_goal = hand_.target();
  command.hand_force_permille = hand_.force_limit_permille();
  const bool is_finite = command.q_rad.allFinite() && command.bend_rad.allFinite() && command.torque_Nm.allFinite() &&
                         std::isfinite(command.hand_closure);
  if (is_driven && !is_finite) {
    raise(now, {FaultCode::kNotFinite});
    command.q_rad = joints.q_rad;
    command.hand_closure = command.hand_goal = joints.hand_closure;
  }
  // A drive that an earlier controller left holding must not drop the arm: power goes off by command only.
  const bool stays_stopped = mode_ == Mode::kFault || mode_ == Mode::kRecovering;
  command.power = stays_stopped  ? PowerRequest::kQuickStop
                  : wants_power_ ? PowerRequest::kOn
                  : asked_off_   ? PowerRequest::kOff
                                 : PowerRequest::kQuickStop;
  command.recover = wants_recover_;
  wants_recover_ = false;
}

// Before power comes the drives' targets are bent already: an enabled drive then stands where the link is.
void Controller::step_soft_joints(const JointSamples& joints, bool is_driven) noexcept {
  JointCommand& command = output_.command;
  const SoftArm& arm = soft_.arm();
  command.torque_Nm = feeds_gravity_ ? gravity_torque(arm.chain, arm.links, arm.gravity_m_s2,
                                                      command.q_rad + adaptation_.model().beta)
                                     : JointVector::Zero(arm_.joint_count());
  if (!motion_.commissioning().is_done()) {
    command.bend_rad = JointVector::Zero(arm_.joint_count());
    return;
  }
  if (!is_driven) soft_.reset();
  soft_.step(command.q_rad, joints.q_rad, adaptation_.model().beta, is_driven && motion_.is_at_rest(), period_s_);
  command.bend_rad = soft_.offset_rad();
}

void Controller::step_stiffness() noexcept {
  stiffness_.step();
  JointCommand& command = output_.command;
  for (std::size_t i = 0; i < static_cast<std::size_t>(arm_.joint_count()); ++i) {
    command.stiffness_permille[i] = stiffness_.permille(i);
    command.stiffness_goal_permille[i] = stiffness_.goal_permille(i);
    soft_.set_preset_share(static_cast<int>(i), stiffness_.share(i));
  }
}

void Controller::announce_model() noexcept {
  announced_start_ = true;
  emit(ModelEvent{adaptation_.model(), adaptation_.covariance(), adaptation_.source(), joints_time_});
}

void Controller::fill_snapshot(const JointSamples& joints) noexcept {
  ArmSnapshot& s = output_.snapshot;
  s.time = joints.time;
  s.mode = mode_;
  s.has_positions = joints.has_positions;
  s.is_still = watch_.is_still() && (mode_ != Mode::kServo || motion_.is_at_rest());
  s.hand_is_moving = hand_.is_moving();
  s.q_reading_rad = joints.q_rad;
  s.speed_rad_s = watch_.speed_rad_s();
  s.q_command_rad = output_.command.q_rad;
  s.torque_Nm = joints.torque_Nm;
  s.hand_closure = joints.hand_closure;
  s.hand_command = output_.command.hand_closure;
  s.stiffness_permille = output_.command.stiffness_permille;
  s.hand_effort_permille = joints.hand_effort_permille;
  s.model = adaptation_.model();
  s.goal = goal_;
  s.fault = fault_;
}

}  // namespace armsight::arm
