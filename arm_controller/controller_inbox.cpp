// Controller, second half: what the messages do. Every one is answered; what is refused changes nothing.
#include "arm_controller/controller.hpp"

#include <algorithm>

namespace armsight::arm {

void Controller::take_inbox(Time now, const TickInbox& inbox) noexcept {
  if (inbox.stop) stop(now, {FaultCode::kStopAsked});
  const bool asks_to_hold = inbox.mode && inbox.mode->wish == PowerWish::kHold;
  if (inbox.mode && may_act(inbox.mode->tag, inbox.stop && asks_to_hold)) take_mode_order(now, *inbox.mode);
  if (inbox.recalibration && may_act(inbox.recalibration->tag)) take_recalibration(*inbox.recalibration);
  if (inbox.proposal && may_act(inbox.proposal->tag)) take_proposal(*inbox.proposal);
  for (std::size_t i = 0; i < inbox.look_count; ++i)
    if (may_act(inbox.looks[i].tag)) take_look(inbox.looks[i]);
  if (inbox.goal && may_act(inbox.goal->tag, inbox.stop)) take_goal(*inbox.goal);
  if (inbox.hand && may_act(inbox.hand->tag, inbox.stop)) take_hand_order(*inbox.hand);
  if (inbox.stiffness && may_act(inbox.stiffness->tag)) take_stiffness_order(*inbox.stiffness);
}

// The link let the order pass under a lease; that may have ended on the way, or somebody asked for a stop beside it.
bool Controller::may_act(const Tag& tag, bool is_stopped) noexcept {
  const bool has_lease = lease_ && lease_->session == tag.session;
  if (has_lease && !is_stopped) return true;
  if (has_lease) emit(AnswerEvent{tag, Answer::kWrongState, "stopped in the same cycle"});
  else emit(AnswerEvent{tag, Answer::kNoLease, "the lease ended"});
  return false;
}

AnswerEvent Controller::answer_mode_order(const ModeOrder& order) noexcept {
  const bool is_fault = mode_ == Mode::kFault;
  if (is_fault && !order.clear_fault) return {order.tag, Answer::kWrongState, "a fault is latched: clear_fault is needed"};
  if (mode_ < Mode::kReady) return {order.tag, Answer::kWrongState, "the drives are not configured yet"};
  if (order.wish == PowerWish::kPowerOff && !order.quick_stop && (mode_ == Mode::kServo || mode_ == Mode::kStopping))
    return {order.tag, Answer::kWrongState, "the arm moves: stop first"};
  return {order.tag, Answer::kAccepted, ""};
}

void Controller::take_mode_order(Time now, const ModeOrder& order) noexcept {
  const AnswerEvent answer = answer_mode_order(order);
  emit(answer);
  if (answer.answer != Answer::kAccepted) return;
  if (mode_ == Mode::kFault) {
    fault_ = {};
    late_in_a_row_ = 0;
    watch_.reset();
    apply(ModeEvent::kClearFault);
  }
  if (order.wish == PowerWish::kHold && mode_ == Mode::kServo) stop(now, {FaultCode::kHoldAsked});
  if (order.quick_stop) stop(now, {FaultCode::kStopAsked});
  wants_power_ = order.wish == PowerWish::kHold;
  asked_off_ = !wants_power_ && !order.quick_stop;
  if (!wants_power_) apply(ModeEvent::kPowerOff);  // an arm that moves gets there once it stands
}

AnswerEvent Controller::judge_goal(const Goal& goal) const noexcept {
  if (mode_ != Mode::kHold && mode_ != Mode::kServo)
    return {goal.tag, Answer::kWrongState, "goals are taken in HOLD and SERVO only"};
  if (const AnswerEvent answer = judge_commissioning(goal); answer.answer != Answer::kAccepted) return answer;
  const LearnedModel& model = adaptation_.model();
  if (goal.kind != GoalKind::kJoints && goal.model_revision != model.revision)
    return {goal.tag, Answer::kStaleModel, "the goal was computed with another model revision"};
  JointVector min_rad, max_rad;
  Motion::reading_limits(motion_.limits(), model.beta, min_rad, max_rad);
  const JointVector q = goal.q_real_rad - model.beta;
  const bool is_inside = (q.array() >= min_rad.array()).all() && (q.array() <= max_rad.array()).all();
  if (!is_inside && goal.commission_joint >= 0)
    return {goal.tag, Answer::kOutOfLimits, "commissioning: more than 2 deg from where power came on"};
  if (!is_inside) return {goal.tag, Answer::kOutOfLimits, "q or q + beta beyond a joint limit"};
  return {goal.tag, Answer::kAccepted, ""};
}

// One joint at a time: with two of unknown sign under way nobody could say which turned.
AnswerEvent Controller::judge_commissioning(const Goal& goal) const noexcept {
  const bool is_for_one = goal.commission_joint >= 0;
  if (!is_for_one && !motion_.commissioning().is_done())
    return {goal.tag, Answer::kNotCommissioned, "a joint is not commissioned: host commission leads through it"};
  if (!is_for_one) return {goal.tag, Answer::kAccepted, ""};
  if (!motion_.commissioning().is_open(goal.commission_joint))
    return {goal.tag, Answer::kWrongState, "that joint is commissioned: it takes goals like every other"};
  if (mode_ != Mode::kHold || !motion_.is_at_rest())
    return {goal.tag, Answer::kMoving, "commissioning: one motion at a time, from standstill"};
  return {goal.tag, Answer::kAccepted, ""};
}

Goal Controller::commissioning_goal(const Goal& goal) const noexcept {
  Goal out = goal;
  if (goal.commission_joint < 0) return out;
  out.q_real_rad = motion_.standing_rad(adaptation_.model().beta);
  out.q_real_rad[goal.commission_joint] = goal.q_real_rad[goal.commission_joint];
  out.speed_scale = std::min(goal.speed_scale, motion_.commissioning().speed_scale(arm_.limits, goal.commission_joint));
  return out;
}

void Controller::take_goal(const Goal& asked) noexcept {
  const Goal goal = commissioning_goal(asked);
  const AnswerEvent answer = judge_goal(goal);
  emit(answer);
  if (answer.answer != Answer::kAccepted) return;
  end_goal(GoalState::kReplaced, "another goal came");
  motion_.start(goal, adaptation_.model());
  goal_ = goal.id;
  goal_is_active_ = true;
  apply(ModeEvent::kGoal);
  GoalEvent event{goal_, GoalState::kMoving, 0.0, 0.0, adaptation_.model().revision, joints_time_, watch_.mean_rad(), ""};
  motion_.errors_at(event.q_reading_rad, adaptation_.model(), event.position_error_m, event.orientation_error_rad);
  emit(event);
}

void Controller::take_hand_order(const HandOrder& order) noexcept {
  if (mode_ != Mode::kHold && mode_ != Mode::kServo)
    return emit(AnswerEvent{order.tag, Answer::kWrongState, "the hand moves in HOLD and SERVO only"});
  hand_.order(order.closure, order.force_limit_permille, order.speed_scale);
  emit(AnswerEvent{order.tag, Answer::kAccepted, ""});
}

void Controller::take_stiffness_order(const StiffnessOrder& order) noexcept {
  stiffness_.order(order.permille);
  emit(AnswerEvent{order.tag, Answer::kAccepted, ""});
}

void Controller::take_recalibration(const RecalibrationOrder& order) noexcept {
  if (mode_ != Mode::kHold && mode_ != Mode::kServo)
    return emit(AnswerEvent{order.tag, Answer::kWrongState, "a recalibration starts in HOLD or SERVO only"});
  adaptation_.begin(order.keep_covariance);
  emit(AnswerEvent{order.tag, Answer::kAccepted, ""});
}

void Controller::take_proposal(const Proposal& proposal) noexcept {
  if (mode_ != Mode::kHold)
    return emit(AnswerEvent{proposal.tag, Answer::kWrongState, "a model is taken in HOLD only"});
  const AnswerEvent answer = adaptation_.take(proposal);
  emit(answer);
  if (answer.answer == Answer::kAccepted) announce_model();
}

void Controller::take_look(const Look& look) noexcept {
  FilterEvent event;
  const std::uint64_t before = adaptation_.model().revision;
  const AnswerEvent answer = adaptation_.take(look, history_, event);
  emit(answer);
  if (answer.answer != Answer::kWrongState) emit(event);
  if (adaptation_.model().revision == before) return;
  motion_.model_changed(adaptation_.model());
  announce_model();
}

}  // namespace armsight::arm
