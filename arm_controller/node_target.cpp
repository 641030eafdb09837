// Node, third part: what goes into RPDO1 in each mode of operation, and "here is zero" (homing methods 35 and 37).
//
//   homing, when first enabled:  kToHomingMode ─► kToEnabled ─► kHoming (bit 4) ─attained─► kToReady ─► kToWorkingMode
//
// The drive stands the whole time; only its count of where it stands changes. Mode changes are made unpowered.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "arm_controller/drive_commands.hpp"
#include "arm_controller/node.hpp"

namespace armsight::arm {
namespace {

constexpr std::uint16_t kNewSetPoint = 1u << 4, kStartHoming = 1u << 4, kChangeAtOnce = 1u << 5;
constexpr std::uint16_t kTargetReached = 1u << 10, kAttained = 1u << 12, kAcknowledged = 1u << 12, kHomingError = 1u << 13;
constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kVelocityGain_1_s = 10.0;  ///< closes the position loop around a velocity drive; stable to 1/(3 cycles)

std::int32_t to_counts(double value) noexcept {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -kMost, kMost)));
}

}  // namespace

double Node::position_rad(Time) const noexcept { return kTurn_rad / options_.counts_per_turn * position_counts(); }

std::optional<CanFrame> Node::set_target(const DriveTarget& target) noexcept {
  const double count_rad = kTurn_rad / options_.counts_per_turn;
  const bool takes_stiffness = options_.stiffness_object && phase_ == NodePhase::kReady && !lacks(stiffness_.object);
  stiffness_.wanted = takes_stiffness ? std::optional(target.stiffness_goal_permille) : std::nullopt;
  return set_point(static_cast<std::int32_t>(std::lround(target.position_rad / count_rad)),
                   static_cast<std::int32_t>(std::lround(target.bend_rad / count_rad)));
}

std::optional<CanFrame> Node::set_point(std::int32_t target_counts, std::int32_t bend_counts) noexcept {
  if (phase_ != NodePhase::kReady) return std::nullopt;
  const bool is_led = is_following() && controlword_ == kEnableOperation;
  if (!is_led) {
    last_target_.reset();
    profile_target_.reset();
    profile_is_new_ = false;
  }
  Rpdo1 command{controlword_, (is_led ? target_counts : feedback_.position_counts) + bend_counts, 0};
  if (options_.script.mode == DriveMode::kCyclicVelocity)
    command.target_counts = is_led ? velocity_counts_s(target_counts) : 0;
  if (is_led && options_.script.mode == DriveMode::kProfilePosition)
    command.controlword = static_cast<std::uint16_t>(controlword_ | profile_bits(target_counts));
  CanFrame frame = encode(command, id());
  if (!has_torque_offset_) frame.size = 6;
  return frame;
}

// Cyclic velocity: the reference's own speed, and a pull towards the reference.
std::int32_t Node::velocity_counts_s(std::int32_t target_counts) noexcept {
  const double step = static_cast<double>(target_counts) - last_target_.value_or(target_counts);
  const double behind = static_cast<double>(target_counts) - feedback_.position_counts;
  last_target_ = target_counts;
  return to_counts(step / options_.period_s + kVelocityGain_1_s * behind);
}

// Profile position: a target counts when bit 4 rises; the drive acknowledges with bit 12, and lets go when bit 4 falls.
std::uint16_t Node::profile_bits(std::int32_t target_counts) noexcept {
  const bool is_acknowledged = (feedback_.statusword & kAcknowledged) != 0;
  if (profile_is_new_ && is_acknowledged) profile_is_new_ = false;
  else if (!profile_is_new_ && !is_acknowledged && profile_target_ != target_counts) {
    profile_is_new_ = true;
    profile_target_ = target_counts;
  }
  return static_cast<std::uint16_t>(kChangeAtOnce | (profile_is_new_ ? kNewSetPoint : 0));
}

void Node::enter_homing(HomingStep step, Time now) noexcept {
  homing_ = step;
  homing_since_ = now;
  sdo_.clear();
}

// Given up half-way: whatever mode the drive is in, it is configured anew before it moves.
void Node::leave_homing() noexcept {
  homing_ = HomingStep::kNone;
  sdo_.clear();
  latch_drive(FaultCode::kHomingFailed);
}

/// Writes 0x6060 and waits until 0x6061 says so; true when it does.
bool Node::switches_mode(DriveMode mode) noexcept {
  const auto wanted = static_cast<std::uint32_t>(mode);
  if (sdo_.result() == SdoResult::kIdle) sdo_.start_write({0x6060, 0}, wanted, 1);
  if (sdo_.result() == SdoResult::kDone && !reads_back_) {
    reads_back_ = true;
    sdo_.start_read({0x6061, 0});
  } else if (sdo_.result() == SdoResult::kDone) {
    if ((sdo_.value() & 0xFF) == wanted) reads_back_ = false;
    else sdo_.start_read({0x6061, 0});
    return !reads_back_;
  }
  if (sdo_.result() == SdoResult::kAborted) latch(FaultCode::kSdoAborted, {0x6060, 0}, sdo_.value());
  if (sdo_.result() == SdoResult::kTimedOut) latch(FaultCode::kSdoTimeout, {0x6060, 0});
  return false;
}

void Node::advance_homing(Time now) noexcept {
  const DriveState state = drive_state_now();
  const std::uint16_t status = feedback_.statusword;
  if (homing_ != HomingStep::kNone && now - homing_since_ > kHomingTimeout) return latch_drive(FaultCode::kHomingFailed);
  const bool is_ready = state == DriveState::kReadyToSwitchOn;
  switch (homing_) {
    case HomingStep::kNone:
      if (sdo_.result() == SdoResult::kPending) return;  // the torque limit; it ends by itself
      reads_back_ = false;
      return enter_homing(HomingStep::kToHomingMode, now);
    case HomingStep::kToHomingMode:
      controlword_ = power_command(PowerRequest::kOff, state);
      if (is_ready && switches_mode(DriveMode::kHoming)) enter_homing(HomingStep::kToEnabled, now);
      return;
    case HomingStep::kToEnabled:
      controlword_ = power_command(PowerRequest::kOn, state);
      if (state == DriveState::kOperationEnabled) enter_homing(HomingStep::kHoming, now);
      return;
    case HomingStep::kHoming:
      controlword_ = kEnableOperation | kStartHoming;
      if (state != DriveState::kOperationEnabled || (status & kHomingError) != 0) return latch_drive(FaultCode::kHomingFailed);
      if ((status & kAttained) != 0 && (status & kTargetReached) != 0) enter_homing(HomingStep::kToReady, now);
      return;
    case HomingStep::kToReady:
      controlword_ = power_command(PowerRequest::kOff, state);
      if (is_ready) enter_homing(HomingStep::kToWorkingMode, now);
      return;
    case HomingStep::kToWorkingMode:
      controlword_ = power_command(PowerRequest::kOff, state);
      if (!switches_mode(options_.script.mode)) return;
      homing_ = HomingStep::kNone;
      sdo_.clear();
      is_homed_ = true;
      state_since_ = now;
      return;
  }
}

}  // namespace armsight::arm
