// Node, second half: the CiA 402 power state machine. Every state is waited for; every wait has an end and a name.
#include "arm_controller/node.hpp"

namespace armsight::arm {
namespace {

constexpr std::uint16_t kFollowsTarget = 1u << 12;  ///< statusword in CSP: 0 = target ignored

}  // namespace

bool Node::is_following() const noexcept {
  return phase_ == NodePhase::kReady && drive_state_now() == DriveState::kOperationEnabled &&
         (feedback_.statusword & kFollowsTarget) != 0;
}

void Node::advance_power(Time now, PowerRequest power) noexcept {
  const DriveState state = drive_state_now();
  if (state != last_state_) {
    last_state_ = state;
    state_since_ = now;
  }
  if (is_resetting_) return advance_reset(now);
  const bool is_fault = state == DriveState::kFault || state == DriveState::kFaultReaction;
  if (is_fault) latch_drive(FaultCode::kDriveFault);
  if (power != PowerRequest::kOn) was_enabled_ = false;
  const std::uint16_t before = controlword_;
  controlword_ = command_for(fault_.is_set() ? PowerRequest::kQuickStop : power, state, now - state_since_ > options_.state_timeout);
  if (controlword_ != before) state_since_ = now;  // the wait begins with the command
  if (power == PowerRequest::kOn && !fault_.is_set()) supervise_power(state, now - state_since_ > options_.state_timeout);
}

void Node::supervise_power(DriveState state, bool state_is_old) noexcept {
  const bool is_enabled = state == DriveState::kOperationEnabled;
  if (is_following()) was_enabled_ = true;
  if (was_enabled_ && !is_enabled) return latch_drive(FaultCode::kDriveLeftOperation);
  if (!state_is_old || is_following()) return;
  latch_drive(is_enabled ? FaultCode::kTargetIgnored : FaultCode::kEnableTimeout);
}

std::uint16_t Node::command_for(PowerRequest power, DriveState state, bool state_is_old) noexcept {
  if (state == DriveState::kFault || state == DriveState::kFaultReaction || state == DriveState::kNotReady)
    return kDisableVoltage;
  switch (power) {
    case PowerRequest::kOff:
      return state == DriveState::kQuickStopActive ? kDisableVoltage : kShutdown;
    case PowerRequest::kQuickStop:
      if (state == DriveState::kOperationEnabled || state == DriveState::kQuickStopActive) return kQuickStop;
      return kShutdown;
    case PowerRequest::kOn: break;
  }
  switch (state) {
    case DriveState::kReadyToSwitchOn: return kSwitchOn;
    case DriveState::kSwitchedOn:
    case DriveState::kOperationEnabled: return kEnableOperation;
    case DriveState::kQuickStopActive:
      // Transition 16 keeps the joint powered; a drive without it goes the long way.
      if (controlword_ == kDisableVoltage) return kDisableVoltage;
      return controlword_ == kEnableOperation && state_is_old ? kDisableVoltage : kEnableOperation;
    default: return kShutdown;
  }
}

// Fault reset acts on a rising edge: first 0, then 0x80 until the fault is gone.
void Node::advance_reset(Time now) noexcept {
  const DriveState state = drive_state_now();
  if (state != DriveState::kFault && state != DriveState::kFaultReaction) {
    is_resetting_ = false;
    controlword_ = kShutdown;
    emergency_ = 0;
    return;
  }
  if (now - reset_since_ > kStartTimeout) {
    is_resetting_ = false;
    return latch_drive(FaultCode::kFaultResetFailed);
  }
  const bool is_low = controlword_ == kDisableVoltage;
  controlword_ = is_low && now > reset_since_ ? kFaultReset : controlword_ == kFaultReset ? kFaultReset : kDisableVoltage;
}

}  // namespace armsight::arm
