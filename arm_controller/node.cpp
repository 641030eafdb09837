#include "arm_controller/node.hpp"

namespace armsight::arm {

Node::Node(const NodeOptions& options) noexcept : options_(options), script_(make_node_script(options.script)) {}

void Node::latch(FaultCode code, const ObjectAddress& object, std::uint32_t detail, std::uint32_t expected) noexcept {
  if (fault_.is_set()) return;  // the first one is the cause
  fault_ = {code, id(), object.index, object.sub, detail, expected};
}

void Node::latch_drive(FaultCode code) noexcept {
  latch(code, {}, feedback_.statusword | (std::uint32_t{emergency_} << 16));
}

void Node::restart(Time now) noexcept {
  phase_ = NodePhase::kAbsent;
  phase_since_ = now;
  fault_ = {};
  sdo_.clear();
  has_feedback_ = feedback_arrived_ = was_enabled_ = is_resetting_ = fell_back_ = false;
  has_torque_offset_ = true;
  missed_feedback_ = feedback_seen_ = 0;
  heartbeat_time_.reset();
  torque_limit_.reset();
  torque_limit_in_flight_.reset();
  controlword_ = kDisableVoltage;
}

void Node::recover(Time now) noexcept {
  const bool is_only_in_fault = phase_ == NodePhase::kReady && fault_.code >= FaultCode::kDriveFault;
  if (fault_.is_set() && !is_only_in_fault) return restart(now);
  fault_ = {};
  was_enabled_ = false;
  if (phase_ != NodePhase::kReady) return;
  is_resetting_ = drive_state_now() == DriveState::kFault || drive_state_now() == DriveState::kFaultReaction;
  reset_since_ = now;
}

void Node::receive(const CanFrame& frame, Time now) noexcept {
  if (const auto heartbeat = decode_heartbeat(frame, id())) {
    heartbeat_time_ = now;
    const bool is_boot = heartbeat->state == NmtState::kBootUp;
    const bool left = heartbeat->state != NmtState::kOperational && phase_ == NodePhase::kReady;
    if ((is_boot && phase_ != NodePhase::kAbsent) || left) return latch(FaultCode::kNodeRestarted);
    if (phase_ == NodePhase::kAbsent) see(now);
  } else if (const auto feedback = decode_tpdo1(frame, id())) {
    if (phase_ != NodePhase::kStarting && phase_ != NodePhase::kReady) return;
    feedback_ = *feedback;
    has_feedback_ = feedback_arrived_ = true;
  } else if (const auto emergency = decode_emcy(frame, id())) {
    if (emergency->code != 0) emergency_ = emergency->code;
  } else {
    sdo_.receive(frame, id());
  }
}

// A node that an earlier controller left operational is taken back to pre-operational before anything is written.
void Node::see(Time now) noexcept {
  phase_ = NodePhase::kConfiguring;
  phase_since_ = now;
  step_ = 0;
  reads_back_ = uses_fall_back_ = false;
  nmt_to_send_ = Nmt{NmtCommand::kPreOperational, id()};
  sdo_.clear();
}

void Node::advance(Time now, bool sync_answered, PowerRequest power) noexcept {
  if (!phase_since_) phase_since_ = now;
  if (!fault_.is_set()) {
    if (phase_ == NodePhase::kAbsent) advance_absent(now);
    if (phase_ == NodePhase::kConfiguring) advance_script(now);
    if (phase_ == NodePhase::kStarting || phase_ == NodePhase::kReady) supervise(now, sync_answered);
  }
  if (phase_ == NodePhase::kReady) advance_power(now, fault_.is_set() ? PowerRequest::kQuickStop : power);
  is_fresh_ = feedback_arrived_;
  feedback_arrived_ = false;
}

// A drive whose heartbeat is off is asked; one that stays silent is named.
void Node::advance_absent(Time now) noexcept {
  if (now - *phase_since_ > kAbsentAfter) return latch(FaultCode::kNodeAbsent);
  if (sdo_.result() == SdoResult::kDone) return see(now);
  const bool is_busy = sdo_.result() == SdoResult::kPending;
  if (!is_busy && now - *phase_since_ > kProbeAfter) sdo_.start_read({0x1000, 0});
}

void Node::supervise(Time now, bool sync_answered) noexcept {
  if (feedback_arrived_) {
    missed_feedback_ = 0;
    if (phase_ == NodePhase::kStarting && ++feedback_seen_ == kFeedbackToStart) {
      phase_ = NodePhase::kReady;
      heartbeat_time_ = now;  // its heartbeat may have begun only just now
    }
  } else if (sync_answered && phase_ == NodePhase::kReady && ++missed_feedback_ >= kMissedFeedbackLimit) {
    latch(FaultCode::kFeedbackMissing);
  }
  if (phase_ == NodePhase::kStarting && now - *phase_since_ > kStartTimeout) latch(FaultCode::kFeedbackMissing);
  if (phase_ == NodePhase::kReady && heartbeat_time_ && now - *heartbeat_time_ > options_.heartbeat_lost_after)
    latch(FaultCode::kHeartbeatLost, {},
          static_cast<std::uint32_t>(options_.heartbeat_lost_after / std::chrono::milliseconds(1)));
}

std::optional<CanFrame> Node::set_point(std::int32_t target_counts) const noexcept {
  if (phase_ != NodePhase::kReady) return std::nullopt;
  const bool is_following_command = is_following() && controlword_ == kEnableOperation;
  CanFrame frame =
      encode(Rpdo1{controlword_, is_following_command ? target_counts : feedback_.position_counts, 0}, id());
  if (!has_torque_offset_) frame.size = 6;
  return frame;
}

std::optional<CanFrame> Node::service_frame(Time now) noexcept {
  if (nmt_to_send_) {
    const CanFrame frame = encode(*nmt_to_send_);
    nmt_to_send_.reset();
    return frame;
  }
  if (phase_ == NodePhase::kReady && sdo_.result() != SdoResult::kPending) {
    if (torque_limit_in_flight_) {
      if (sdo_.result() == SdoResult::kDone) torque_limit_ = torque_limit_in_flight_;
      if (sdo_.result() == SdoResult::kTimedOut) latch(FaultCode::kSdoTimeout, {0x6072, 0});
      if (sdo_.result() == SdoResult::kAborted) latch(FaultCode::kSdoAborted, {0x6072, 0}, sdo_.value());
      torque_limit_in_flight_.reset();
      sdo_.clear();
    }
    if (!fault_.is_set() && wanted_torque_limit_ != torque_limit_) {
      torque_limit_in_flight_ = wanted_torque_limit_;
      sdo_.start_write({0x6072, 0}, *wanted_torque_limit_, 2);
    }
  }
  return sdo_.request_to_send(id(), now);
}

}  // namespace armsight::arm
