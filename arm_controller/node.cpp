#include "arm_controller/node.hpp"

namespace armsight::arm {

Node::Node(const NodeOptions& options) noexcept : options_(options), script_(make_node_script(options.script)) {
  stiffness_.object = options.stiffness_object.value_or(ObjectAddress{});
  begin_check();
}

void Node::latch(const Fault& fault) noexcept {
  if (!fault_.is_set()) fault_ = check_.fault = fault;  // the first one is the cause
}

void Node::latch(FaultCode code, const ObjectAddress& object, std::uint32_t detail, std::uint32_t expected) noexcept {
  latch({code, id(), object.index, object.sub, detail, expected});
}

void Node::latch_silence(FaultCode code, std::optional<Time> last, Time now) noexcept {
  const bool is_heartbeat = code == FaultCode::kHeartbeatLost;
  const auto limit_ms = is_heartbeat ? options_.heartbeat_lost_after / std::chrono::milliseconds(1) : 0;
  latch({code, id(), 0, 0, static_cast<std::uint32_t>(limit_ms), 0, last ? (now - *last).count() : -1});
}

void Node::latch_drive(FaultCode code) noexcept {
  latch(code, {}, feedback_.statusword | (std::uint32_t{emergency_} << 16), error_register_);
}

void Node::restart(Time now) noexcept {
  phase_ = NodePhase::kAbsent;
  phase_since_ = now;
  fault_ = {};
  begin_check();
  sdo_.clear();
  has_feedback_ = feedback_arrived_ = was_enabled_ = is_resetting_ = fell_back_ = false;
  has_torque_offset_ = true;
  missed_feedback_ = feedback_seen_ = 0;
  heartbeat_time_.reset();
  for (Setting* setting : {&torque_limit_, &stiffness_}) {
    setting->taken.reset();
    setting->in_flight.reset();
  }
  controlword_ = kDisableVoltage;
  is_homed_ = false;
  homing_ = HomingStep::kNone;
}

void Node::begin_check() noexcept {
  check_ = {};
  check_.node = id();
  check_.mode = options_.script.mode;
  check_.homing_method = options_.script.homing_method;
}

void Node::recover(Time now) noexcept {
  const bool is_half_homed = fault_.code == FaultCode::kHomingFailed;  // in which mode is the drive?
  const bool is_only_in_fault = phase_ == NodePhase::kReady && fault_.code >= FaultCode::kDriveFault && !is_half_homed;
  if (fault_.is_set() && !is_only_in_fault) return restart(now);
  fault_ = check_.fault = {};
  homing_ = HomingStep::kNone;
  emergencies_ = 0;
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
    feedback_time_ = now;
    has_feedback_ = feedback_arrived_ = true;
  } else if (const auto emergency = decode_emcy(frame, id())) {
    take_emergency(*emergency, now);
  } else {
    sdo_.receive(frame, id());
  }
}

// One is news, fifty a second are a drive that has lost itself and a bus that carries little else.
void Node::take_emergency(const Emcy& emergency, Time now) noexcept {
  if (now - emergencies_since_ > std::chrono::seconds(1)) {
    emergencies_since_ = now;
    emergencies_ = 0;
  }
  ++emergencies_;
  if (emergency.code == 0) return;
  emergency_ = emergency.code;
  error_register_ = emergency.error_register;
  if (emergencies_ >= kEmergencyStorm)
    latch(FaultCode::kEmergencyStorm, {}, static_cast<std::uint32_t>(emergencies_) | std::uint32_t{emergency_} << 16);
}

// A node that an earlier controller left operational is taken back to pre-operational before anything is written.
void Node::see(Time now) noexcept {
  phase_ = NodePhase::kConfiguring;
  phase_since_ = now;
  step_ = 0;
  begin_check();
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
      check_.is_ready = true;
      heartbeat_time_ = now;  // its heartbeat may have begun only just now
    }
  } else if (sync_answered && phase_ == NodePhase::kReady && ++missed_feedback_ >= kMissedFeedbackLimit) {
    latch_silence(FaultCode::kFeedbackMissing, feedback_time_, now);
  }
  if (phase_ == NodePhase::kStarting && now - *phase_since_ > kStartTimeout)
    latch_silence(FaultCode::kFeedbackMissing, has_feedback_ ? std::optional(feedback_time_) : std::nullopt, now);
  if (phase_ == NodePhase::kReady && heartbeat_time_ && now - *heartbeat_time_ > options_.heartbeat_lost_after)
    latch_silence(FaultCode::kHeartbeatLost, heartbeat_time_, now);
}

std::optional<CanFrame> Node::service_frame(Time now) noexcept {
  if (nmt_to_send_) {
    const CanFrame frame = encode(*nmt_to_send_);
    nmt_to_send_.reset();
    return frame;
  }
  if (phase_ == NodePhase::kReady && homing_ == HomingStep::kNone) {
    if (!stiffness_.in_flight) keep_setting(torque_limit_);
    if (!torque_limit_.in_flight) keep_setting(stiffness_);
  }
  return sdo_.request_to_send(id(), now);
}

/// One exchange at a time; what the drive refuses is a fault.
void Node::keep_setting(Setting& setting) noexcept {
  if (sdo_.result() == SdoResult::kPending) return;
  if (setting.in_flight) {
    if (sdo_.result() == SdoResult::kDone) setting.taken = setting.in_flight;
    if (sdo_.result() == SdoResult::kTimedOut) latch(FaultCode::kSdoTimeout, setting.object);
    if (sdo_.result() == SdoResult::kAborted) latch(FaultCode::kSdoAborted, setting.object, sdo_.value());
    setting.in_flight.reset();
    sdo_.clear();
  }
  if (fault_.is_set() || !setting.wanted || setting.wanted == setting.taken) return;
  setting.in_flight = setting.wanted;
  sdo_.start_write(setting.object, *setting.wanted, 2);
}

}  // namespace armsight::arm
