#include "tools/sim/drive_node.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace armsight::sim {

namespace {

constexpr std::uint32_t kProfile = 1, kHoming = 6, kCsp = 8, kCsv = 9;  ///< 0x6060
constexpr std::uint32_t kModes = 1u << (kProfile - 1) | 1u << (kHoming - 1) | 1u << (kCsp - 1) | 1u << (kCsv - 1);
constexpr std::uint16_t kVoltage = 0x0010, kRemote = 0x0200, kReached = 0x0400, kFollows = 0x1000;
constexpr std::uint16_t kBit4 = 0x0010, kAcknowledged = 0x1000, kHomingAttained = 0x1000;
constexpr std::uint16_t kFaultResetBit = 0x80;
constexpr std::uint16_t kFollowingError = 0x8611;
constexpr std::uint8_t kGenericError = 0x01, kMotionError = 0x20;
constexpr std::uint32_t kFullStiffness_permille = 1000;
constexpr std::uint32_t kRatedTorque_mNm = 6000;  // actuator of specification §4.4

}  // namespace

DriveState next_drive_state(DriveState state, std::uint16_t cw, std::uint32_t quick_stop_option,
                            bool fault_reset_edge) {
  using enum DriveState;
  enum Command { kToShutdown, kToSwitchOn, kToEnable, kToQuickStop, kToDisable, kCommands };
  // Rows: states; columns: shutdown, switch on (= disable operation), enable operation, quick stop, disable voltage.
  static constexpr DriveState kTable[][kCommands] = {
      /* not ready    */ {kNotReady, kNotReady, kNotReady, kNotReady, kNotReady},
      /* disabled     */ {kReadyToSwitchOn, kSwitchOnDisabled, kSwitchOnDisabled, kSwitchOnDisabled, kSwitchOnDisabled},
      /* ready        */ {kReadyToSwitchOn, kSwitchedOn, kSwitchedOn, kSwitchOnDisabled, kSwitchOnDisabled},
      /* switched on  */ {kReadyToSwitchOn, kSwitchedOn, kOperationEnabled, kSwitchOnDisabled, kSwitchOnDisabled},
      /* enabled      */ {kReadyToSwitchOn, kSwitchedOn, kOperationEnabled, kQuickStopActive, kSwitchOnDisabled},
      /* quick stop   */ {kQuickStopActive, kQuickStopActive, kOperationEnabled, kQuickStopActive, kSwitchOnDisabled},
      /* reaction     */ {kFaultReaction, kFaultReaction, kFaultReaction, kFaultReaction, kFaultReaction},
      /* fault        */ {kFault, kFault, kFault, kFault, kFault},
  };
  if (state == kFault && fault_reset_edge) return kSwitchOnDisabled;
  const Command command = (cw & 0x02) == 0     ? kToDisable
                          : (cw & 0x04) == 0   ? kToQuickStop
                          : (cw & 0x01) == 0   ? kToShutdown
                          : (cw & 0x08) == 0   ? kToSwitchOn
                                               : kToEnable;
  const bool stays_powered = quick_stop_option >= 5 && quick_stop_option <= 8;  // transition 16 is theirs alone
  if (state == kQuickStopActive && command == kToEnable && !stays_powered) return state;
  return kTable[static_cast<std::size_t>(state)][command];
}

std::uint16_t state_bits(DriveState state) {
  switch (state) {
    case DriveState::kSwitchOnDisabled: return 0x40;
    case DriveState::kReadyToSwitchOn: return 0x21;
    case DriveState::kSwitchedOn: return 0x23;
    case DriveState::kOperationEnabled: return 0x27;
    case DriveState::kQuickStopActive: return 0x07;
    case DriveState::kFaultReaction: return 0x0F;
    case DriveState::kFault: return 0x08;
    case DriveState::kNotReady:
    case DriveState::kUnknown: break;
  }
  return 0;
}

DriveNode::DriveNode(std::uint8_t node, SendFrame send, Motor& motor, OnSample on_sample)
    : CanopenDevice(node, std::move(send)), motor_(motor), on_sample_(std::move(on_sample)) {
  add_drive_objects();
}

void DriveNode::add_drive_objects() {
  const auto fixed = [this](std::uint16_t i, std::uint8_t s, std::uint8_t size, std::uint32_t v) {
    objects_.add(i, s, size, Access::kReadOnly, v);
  };
  const auto free = [this](std::uint16_t i, std::uint8_t s, std::uint8_t size, std::uint32_t v) {
    objects_.add(i, s, size, Access::kReadWrite, v);
  };
  fixed(0x603F, 0, 2, 0);
  free(0x6007, 0, 2, 1);
  free(0x605A, 0, 2, 2);
  free(0x605B, 0, 2, 0);
  free(0x605C, 0, 2, 1);
  free(0x605D, 0, 2, 1);
  free(0x605E, 0, 2, 2);
  free(0x6040, 0, 2, 0);
  fixed(0x6041, 0, 2, 0);
  free(0x6060, 0, 1, 0);
  fixed(0x6061, 0, 1, 0);
  fixed(0x6064, 0, 4, 0);
  free(0x6065, 0, 4, motor_.following_window_counts());
  fixed(0x606C, 0, 4, 0);
  free(0x6072, 0, 2, 1000);
  fixed(0x6076, 0, 4, kRatedTorque_mNm);
  fixed(0x6077, 0, 2, 0);
  free(0x607A, 0, 4, 0);
  fixed(0x608F, 0, 1, 2);
  fixed(0x608F, 1, 4, motor_.counts_per_turn());
  fixed(0x608F, 2, 4, 1);
  fixed(0x6091, 0, 1, 2);
  fixed(0x6091, 1, 4, 1);
  fixed(0x6091, 2, 4, 1);
  free(0x607C, 0, 4, 0);
  free(0x6081, 0, 4, motor_.counts_per_turn());
  free(0x6083, 0, 4, motor_.counts_per_turn());
  free(0x6084, 0, 4, motor_.counts_per_turn());
  free(0x6085, 0, 4, 4 * motor_.counts_per_turn());
  free(0x6098, 0, 1, 37);
  free(0x60B2, 0, 2, 0);
  free(0x60FF, 0, 4, 0);
  fixed(0x60C2, 0, 1, 2);
  free(0x60C2, 1, 1, 1);
  free(0x60C2, 2, 1, 0xFD);
  fixed(0x6502, 0, 4, kModes);
  fixed(0x20F0, 0, 1, 2);
  fixed(0x20F0, 1, 2, kFullStiffness_permille);
  free(0x20F0, 2, 2, kFullStiffness_permille);
}

std::optional<std::uint32_t> DriveNode::live_value(ObjectAddress object) {
  switch (object.index) {
    case 0x6041: return statusword();
    case 0x6061: return objects_.get(0x6060);
    case 0x6064: {
      const bool is_in_step = nmt_state() == NmtState::kOperational;
      return static_cast<std::uint32_t>(is_in_step ? sampled_counts_ : position());
    }
    case 0x20F0: return object.sub == 1 ? std::optional(objects_.get(0x20F0, 2)) : std::nullopt;
    case 0x6077: return static_cast<std::uint16_t>(motor_.torque_permille());
    default: return std::nullopt;
  }
}

std::uint32_t DriveNode::judge(ObjectAddress object, std::uint32_t value) const {
  switch (object.index) {
    case 0x6007: return value <= 3 ? 0 : kBadValue;
    case 0x605A: return value <= 2 || value == 5 || value == 6 ? 0 : kBadValue;
    case 0x605E: return value <= 2 ? 0 : kBadValue;
    case 0x6060: return value >= 1 && value <= 10 && (kModes >> (value - 1) & 1) != 0 ? 0 : kBadValue;
    case 0x6098: return value == 35 || value == 37 ? 0 : kBadValue;
    case 0x20F0: return value <= kFullStiffness_permille ? 0 : kBadValue;
    case 0x6072: return value <= 1000 ? 0 : kBadValue;
    case 0x60C2: return object.sub == 1 && value == 0 ? kBadValue : 0;
    default: return 0;
  }
}

bool DriveNode::is_receive_mappable(std::uint16_t index) const {
  return index == 0x6040 || index == 0x607A || index == 0x60FF || index == 0x60B2 || index == 0x6072;
}

bool DriveNode::is_transmit_mappable(std::uint16_t index) const {
  return index == 0x6041 || index == 0x6064 || index == 0x6077 || index == 0x603F || index == 0x6061;
}

std::uint16_t DriveNode::statusword() const {
  std::uint16_t word = state_bits(state_) | kRemote;
  const bool is_powered = state_ == DriveState::kSwitchedOn || state_ == DriveState::kOperationEnabled ||
                          state_ == DriveState::kQuickStopActive;
  if (is_powered) word |= kVoltage;
  if (state_ != DriveState::kOperationEnabled) return word;
  switch (objects_.get(0x6060)) {
    case kCsp:
    case kCsv: return static_cast<std::uint16_t>(word | kFollows);
    case kProfile: return static_cast<std::uint16_t>(is_acknowledged_ ? word | kAcknowledged : word);
    case kHoming: return static_cast<std::uint16_t>(is_homed_ ? word | kHomingAttained | kReached : word);
    default: return word;
  }
}

void DriveNode::on_sync(Time now) {
  sampled_counts_ = position();
  if (on_sample_) on_sample_(sampled_counts_, now);
}

void DriveNode::act(Time now) {
  const auto cw = static_cast<std::uint16_t>(objects_.get(0x6040));
  const bool is_edge = (cw & kFaultResetBit) != 0 && (last_controlword_ & kFaultResetBit) == 0;
  last_controlword_ = cw;
  act_on_bit_4(cw);
  const bool asks_to_follow = (cw & 0x0F) == kEnableOperation;
  if (!asks_to_follow) must_release_ = false;
  const bool is_ignored = must_release_ && state_ == DriveState::kQuickStopActive;
  const DriveState before = state_;
  DriveState next = is_ignored ? state_ : next_drive_state(state_, cw, objects_.get(0x605A), is_edge);
  if (is_held_back_ && next == DriveState::kOperationEnabled) next = state_;
  state_ = next;
  if (before == DriveState::kFault && state_ != before) {
    objects_.set({0x603F, 0}, 0);
    send_emergency(0x0000, 0, now);
  }
  if (state_ != before && state_ == DriveState::kOperationEnabled) target_ = sampled_counts_;
  lead_target(now);
  const auto window = static_cast<std::int64_t>(objects_.get(0x6065));
  const std::int64_t behind = objects_.get(0x6060) == kCsp ? std::llabs(std::int64_t{target_} - sampled_counts_) : 0;
  if (state_ == DriveState::kOperationEnabled && window != 0 && behind > window) return fault(kFollowingError, now);
  drive_motor();
}

std::int32_t DriveNode::position() { return motor_.position_counts() + zero_; }

/// Bit 4 rising: a new target in profile position, "here is zero" in homing.
void DriveNode::act_on_bit_4(std::uint16_t controlword) {
  const bool is_up = (controlword & kBit4) != 0, is_edge = is_up && !bit_4_was_up_;
  bit_4_was_up_ = is_up;
  is_acknowledged_ = is_up;
  if (state_ != DriveState::kOperationEnabled || !is_edge) return;
  if (objects_.get(0x6060) == kProfile) profile_target_ = static_cast<std::int32_t>(objects_.get(0x607A));
  if (objects_.get(0x6060) != kHoming) return;
  zero_ = static_cast<std::int32_t>(objects_.get(0x607C)) - motor_.position_counts();
  sampled_counts_ = target_ = position();
  is_homed_ = true;
}

/// Where the motor shall be, for each mode. A velocity leads its target on, but never far ahead of a blocked joint.
void DriveNode::lead_target(Time now) {
  const double dt_s = std::min(to_seconds(now - last_act_), 0.1);
  last_act_ = now;
  if (state_ != DriveState::kOperationEnabled) {
    target_ = profile_target_ = sampled_counts_;
    led_ = target_;
    return;
  }
  const auto lead_to = [&](double goal) {
    led_ = goal;
    target_ = static_cast<std::int32_t>(std::lround(led_));
  };
  switch (objects_.get(0x6060)) {
    case kCsp: return lead_to(static_cast<std::int32_t>(objects_.get(0x607A)));
    case kCsv: {
      const double ahead = motor_.counts_per_turn() / 20.0;
      const double next = led_ + static_cast<std::int32_t>(objects_.get(0x60FF)) * dt_s;
      return lead_to(std::clamp(next, sampled_counts_ - ahead, sampled_counts_ + ahead));
    }
    case kProfile: {
      const double most = objects_.get(0x6081) * dt_s;
      return lead_to(led_ + std::clamp(profile_target_ - led_, -most, most));
    }
    default: return;
  }
}

void DriveNode::drive_motor() {
  motor_.set_stiffness(static_cast<std::uint16_t>(objects_.get(0x20F0, 2)));
  const auto limit = static_cast<std::uint16_t>(objects_.get(0x6072));
  const bool follows = state_ == DriveState::kOperationEnabled && objects_.get(0x6060) != 0;
  const bool stands = state_ == DriveState::kQuickStopActive || state_ == DriveState::kOperationEnabled ||
                      state_ == DriveState::kSwitchedOn;
  motor_.command(follows ? MotorMode::kFollow : stands ? MotorMode::kStop : MotorMode::kOff, target_ - zero_, limit);
}

void DriveNode::force(DriveState state) {
  state_ = state;
  target_ = profile_target_ = position();
  led_ = target_;
  drive_motor();
}

void DriveNode::fault(std::uint16_t code, Time now) {
  state_ = DriveState::kFault;
  objects_.set({0x603F, 0}, code);
  send_emergency(code, kGenericError | kMotionError, now);
  drive_motor();
}

void DriveNode::lose(Loss, Time now) {
  const std::uint32_t reaction = objects_.get(0x6007);
  if (state_ != DriveState::kOperationEnabled || reaction == 0) return;
  if (reaction == 1) return fault(0x8100, now);
  const bool quick_stops = reaction == 3;
  const bool stays_powered = objects_.get(0x605A) >= 5;
  state_ = quick_stops && stays_powered ? DriveState::kQuickStopActive : DriveState::kSwitchOnDisabled;
  must_release_ = true;
  drive_motor();
}

void DriveNode::reset(Time) {
  add_drive_objects();
  state_ = DriveState::kSwitchOnDisabled;
  must_release_ = is_homed_ = is_acknowledged_ = bit_4_was_up_ = false;
  last_controlword_ = 0;
  zero_ = 0;
  drive_motor();
}

}  // namespace armsight::sim
