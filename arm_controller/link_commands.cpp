// LinkServer, second part: commands of the lease's holder. Judged here for form and reach, by the tick for state.
#include "arm_controller/link_server.hpp"

namespace armsight::arm {

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
  const std::optional<Order> replaced = slot.put(order);
  if (!replaced) return;
  for (auto& session : sessions_)
    if (session->session == replaced->tag.session)
      send_refusal(*session, replaced->tag.sequence,
                   {wire::REFUSAL_REASON_OVERFLOW, "replaced by a newer one before the next cycle"}, m.now);
}

void LinkServer::on_command(const Message& m) {
  const wire::Envelope& e = m.envelope;
  if (!state_.has_positions && !e.has_mode_request())
    return refuse(m, {wire::REFUSAL_REASON_WRONG_STATE, "the joints have not reported yet"});
  switch (e.body_case()) {
    case wire::Envelope::kModeRequest: return hand_on(m, mailboxes_.mode, e.mode_request());
    case wire::Envelope::kJointGoal:
      if (!is_expired(m, e.joint_goal().valid_for_ns())) hand_on(m, mailboxes_.goal, e.joint_goal(), view());
      return;
    case wire::Envelope::kPoseGoal:
      if (!is_expired(m, e.pose_goal().valid_for_ns())) hand_on(m, mailboxes_.goal, e.pose_goal(), view());
      return;
    case wire::Envelope::kHandCommand: return hand_on(m, mailboxes_.hand, e.hand_command());
    case wire::Envelope::kModelProposal: return hand_on(m, mailboxes_.proposal, e.model_proposal(), view());
    case wire::Envelope::kRecalibrationStart:
      mailboxes_.recalibration.put({m.tag(), e.recalibration_start().keep_covariance()});
      return;
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
