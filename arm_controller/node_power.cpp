// Node, second half: the CiA 402 power state machine. Every state is waited for; every wait has an end and a name.
#include <utility>

#include "arm_controller/drive_commands.hpp"
#include "arm_controller/node.hpp"

namespace armsight::arm {
namespace {

constexpr std::uint16_t kFollowsTarget = 1u << 12;  ///< statusword in CSP and CSV: 0 = target ignored

}  // namespace

bool Node::is_following() const noexcept {
  const bool heeds = options_.script.mode == DriveMode::kProfilePosition || (feedback_.statusword & kFollowsTarget) != 0;
  return phase_ == NodePhase::kReady && drive_state_now() == DriveState::kOperationEnabled && heeds && !needs_homing();
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
  if (power != PowerRequest::kOn) {
    was_enabled_ = false;
    if (homing_ != HomingStep::kNone) leave_homing();
  } else if (!fault_.is_set() && needs_homing()) {
    return advance_homing(now);
  }
  const std::uint16_t before = controlword_;
  controlword_ = command_for(fault_.is_set() ? PowerRequest::kQuickStop : power, state, now - state_since_ > options_.state_timeout);
  if (controlword_ != before) state_since_ = now;  // the wait begins with the command
  if (power == PowerRequest::kOn && !fault_.is_set()) supervise_power(state, now - state_since_ > options_.state_timeout);
}

void Node::stop(Time now) noexcept {
  if (phase_ != NodePhase::kReady || is_resetting_ || homing_ != HomingStep::kNone) return;
  const std::uint16_t before = std::exchange(controlword_, power_command(PowerRequest::kQuickStop, drive_state_now()));
  if (controlword_ != before) state_since_ = now;
}

void Node::supervise_power(DriveState state, bool state_is_old) noexcept {
  const bool is_enabled = state == DriveState::kOperationEnabled;
  if (is_following()) was_enabled_ = true;
  if (was_enabled_ && !is_enabled) return latch_drive(FaultCode::kDriveLeftOperation);
  if (!state_is_old || is_following()) return;
  latch_drive(is_enabled ? FaultCode::kTargetIgnored : FaultCode::kEnableTimeout);
}

std::uint16_t Node::command_for(PowerRequest power, DriveState state, bool state_is_old) noexcept {
  const bool is_transition_16 = power == PowerRequest::kOn && state == DriveState::kQuickStopActive;
  // Transition 16 keeps the joint powered; a drive without it goes the long way.
  const bool lacks_16 = controlword_ == kDisableVoltage || (controlword_ == kEnableOperation && state_is_old);
  if (is_transition_16 && lacks_16) return kDisableVoltage;
  return power_command(power, state);
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
