// LinkServer, second part: commands of the lease's holder. Judged here for form and reach, by the tick for state.
#include "arm_controller/link_server.hpp"

namespace armsight::arm {
namespace {

const Refused kReplaced{wire::REFUSAL_REASON_OVERFLOW, "replaced by a newer one before the next cycle"};

}  // namespace

bool LinkServer::is_expired(const Message& m, std::int64_t valid_for_ns) {
  const Duration age = m.peer.age(m.arrival, m.envelope.sent_time_ns());
  if (valid_for_ns > 0 && age.count() <= valid_for_ns) return false;
  refuse(m, {wire::REFUSAL_REASON_EXPIRED, "valid_for_ns = " + std::to_string(valid_for_ns) + ": the message is " +
                                               std::to_string(age.count()) + " ns old"});
  return true;
}

// A value that the tick had not taken yet is replaced by the newer one; its sender is told.
template <typename Order, typename Body, typename... View>
void LinkServer::hand_on(const Message& m, Slot<Order>& slot, const Body& body, const View&... view) {
  Order order;
  if (auto no = read_order(body, view..., order)) return refuse(m, *no);
  order.tag = m.tag();
  if (const std::optional<Order> replaced = slot.put(order)) send_refusal(replaced->tag, kReplaced, m.now);
}

// Inverse kinematics takes milliseconds, and a Stop or a heartbeat behind it must not wait: one goal a step, the newest,
// after all the rest of the step.
void LinkServer::keep_pose_goal(const Message& m) {
  drop_pose_goal(kReplaced, m.now);
  pose_goal_ = {m.peer.session, m.envelope, m.arrival};
}

void LinkServer::judge_pose_goal(Time now) {
  if (!pose_goal_) return;
  const PoseGoalInHand taken = std::move(*pose_goal_);
  pose_goal_.reset();
  for (auto& session : sessions_)
    if (session->session == taken.session)
      hand_on({*session, taken.envelope, taken.arrival, now}, mailboxes_.goal, taken.envelope.pose_goal(), view());
}

void LinkServer::drop_pose_goal(const Refused& why, Time now) {
  if (!pose_goal_) return;
  const Tag tag{pose_goal_->session, pose_goal_->envelope.sequence()};
  pose_goal_.reset();
  send_refusal(tag, why, now);
}

void LinkServer::on_command(const Message& m) {
  const wire::Envelope& e = m.envelope;
  if (!state_.has_positions && !e.has_mode_request())
    return refuse(m, {wire::REFUSAL_REASON_WRONG_STATE, "the joints have not reported yet"});
  switch (e.body_case()) {
    case wire::Envelope::kModeRequest: return hand_on(m, mailboxes_.mode, e.mode_request());
    case wire::Envelope::kJointGoal:
      if (is_expired(m, e.joint_goal().valid_for_ns())) return;
      drop_pose_goal(kReplaced, m.now);
      return hand_on(m, mailboxes_.goal, e.joint_goal(), view());
    case wire::Envelope::kPoseGoal:
      if (!is_expired(m, e.pose_goal().valid_for_ns())) keep_pose_goal(m);
      return;
    case wire::Envelope::kHandCommand: return hand_on(m, mailboxes_.hand, e.hand_command());
    case wire::Envelope::kStiffnessCommand:
      return hand_on(m, mailboxes_.stiffness, e.stiffness_command(), view());
    case wire::Envelope::kModelProposal: return hand_on(m, mailboxes_.proposal, e.model_proposal(), view());
    case wire::Envelope::kRecalibrationStart: return hand_on(m, mailboxes_.recalibration, e.recalibration_start());
    case wire::Envelope::kHandPose: return on_look(m);
    default: return;
  }
}

void LinkServer::on_look(const Message& m) {
  Look look;
  if (auto no = read_order(m.envelope.hand_pose(), view(), look)) return refuse(m, *no);
  look.tag = m.tag();
  if (!mailboxes_.looks.push(look)) refuse(m, {wire::REFUSAL_REASON_OVERFLOW, "too many looks at once"});
}

}  // namespace armsight::arm
