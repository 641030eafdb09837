#include "tools/sim/drive_node.hpp"

#include <cstdlib>

namespace armsight::sim {

namespace {

constexpr std::uint8_t kCsp = 8;
constexpr std::uint16_t kVoltage = 0x0010, kRemote = 0x0200, kFollows = 0x1000;
constexpr std::uint16_t kFaultResetBit = 0x80;
constexpr std::uint16_t kFollowingError = 0x8611;
constexpr std::uint8_t kGenericError = 0x01, kMotionError = 0x20;
constexpr std::uint32_t kRatedTorque_mNm = 6000;  // actuator of specification §4.4

}  // namespace

DriveState next_drive_state(DriveState state, std::uint16_t cw, std::uint32_t quick_stop_option,
                            bool fault_reset_edge) {
  using enum DriveState;
  if (state == kFault) return fault_reset_edge ? kSwitchOnDisabled : kFault;
  const bool is_powered = state == kSwitchedOn || state == kOperationEnabled || state == kQuickStopActive;
  if ((cw & 0x02) == 0) return is_powered || state == kReadyToSwitchOn ? kSwitchOnDisabled : state;
  if ((cw & 0x04) == 0) {
    if (state == kOperationEnabled) return kQuickStopActive;
    return state == kReadyToSwitchOn || state == kSwitchedOn ? kSwitchOnDisabled : state;
  }
  const int command = cw & 0x0F;
  if ((command & 0x07) == kShutdown)
    return state == kSwitchOnDisabled || state == kSwitchedOn || state == kOperationEnabled ? kReadyToSwitchOn : state;
  if (command == kSwitchOn)
    return state == kReadyToSwitchOn || state == kOperationEnabled ? kSwitchedOn : state;
  if (state == kReadyToSwitchOn) return kSwitchedOn;
  if (state == kSwitchedOn) return kOperationEnabled;
  const bool stays_powered = quick_stop_option >= 5 && quick_stop_option <= 8;
  return state == kQuickStopActive && stays_powered ? kOperationEnabled : state;
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
  free(0x60B2, 0, 2, 0);
  fixed(0x60C2, 0, 1, 2);
  free(0x60C2, 1, 1, 1);
  free(0x60C2, 2, 1, 0xFD);
  fixed(0x6502, 0, 4, 1u << (kCsp - 1));
}

std::optional<std::uint32_t> DriveNode::live_value(ObjectAddress object) {
  switch (object.index) {
    case 0x6041: return statusword();
    case 0x6061: return objects_.get(0x6060);
    case 0x6064: {
      const bool is_in_step = nmt_state() == NmtState::kOperational;
      return static_cast<std::uint32_t>(is_in_step ? sampled_counts_ : motor_.position_counts());
    }
    case 0x6077: return static_cast<std::uint16_t>(motor_.torque_permille());
    default: return std::nullopt;
  }
}

std::uint32_t DriveNode::judge(ObjectAddress object, std::uint32_t value) const {
  switch (object.index) {
    case 0x6007: return value <= 3 ? 0 : kBadValue;
    case 0x605A: return value <= 2 || value == 5 || value == 6 ? 0 : kBadValue;
    case 0x605E: return value <= 2 ? 0 : kBadValue;
    case 0x6060: return value == kCsp ? 0 : kBadValue;
    case 0x6072: return value <= 1000 ? 0 : kBadValue;
    case 0x60C2: return object.sub == 1 && value == 0 ? kBadValue : 0;
    default: return 0;
  }
}

bool DriveNode::is_receive_mappable(std::uint16_t index) const {
  return index == 0x6040 || index == 0x607A || index == 0x60B2 || index == 0x6072;
}

bool DriveNode::is_transmit_mappable(std::uint16_t index) const {
  return index == 0x6041 || index == 0x6064 || index == 0x6077 || index == 0x603F || index == 0x6061;
}

std::uint16_t DriveNode::statusword() const {
  std::uint16_t word = state_bits(state_) | kRemote;
  const bool is_powered = state_ == DriveState::kSwitchedOn || state_ == DriveState::kOperationEnabled ||
                          state_ == DriveState::kQuickStopActive;
  if (is_powered) word |= kVoltage;
  if (state_ == DriveState::kOperationEnabled && objects_.get(0x6060) == kCsp) word |= kFollows;
  return word;
}

void DriveNode::on_sync(Time now) {
  sampled_counts_ = motor_.position_counts();
  if (on_sample_) on_sample_(sampled_counts_, now);
}

void DriveNode::act(Time now) {
  const auto cw = static_cast<std::uint16_t>(objects_.get(0x6040));
  const bool is_edge = (cw & kFaultResetBit) != 0 && (last_controlword_ & kFaultResetBit) == 0;
  last_controlword_ = cw;
  const bool asks_to_follow = (cw & 0x0F) == kEnableOperation;
  if (!asks_to_follow) must_release_ = false;
  const bool is_ignored = must_release_ && state_ == DriveState::kQuickStopActive;
  const DriveState before = state_;
  if (!is_ignored) state_ = next_drive_state(state_, cw, objects_.get(0x605A), is_edge);
  if (before == DriveState::kFault && state_ != before) {
    objects_.set({0x603F, 0}, 0);
    send_emergency(0x0000, 0, now);
  }
  const auto window = static_cast<std::int64_t>(objects_.get(0x6065));
  const auto target = static_cast<std::int32_t>(objects_.get(0x607A));
  const std::int64_t behind = std::llabs(std::int64_t{target} - sampled_counts_);
  if (state_ == DriveState::kOperationEnabled && window != 0 && behind > window) return fault(kFollowingError, now);
  drive_motor();
}

void DriveNode::drive_motor() {
  const auto target = static_cast<std::int32_t>(objects_.get(0x607A));
  const auto limit = static_cast<std::uint16_t>(objects_.get(0x6072));
  const bool follows = state_ == DriveState::kOperationEnabled && objects_.get(0x6060) == kCsp;
  const bool stands = state_ == DriveState::kQuickStopActive || state_ == DriveState::kOperationEnabled ||
                      state_ == DriveState::kSwitchedOn;
  motor_.command(follows ? MotorMode::kFollow : stands ? MotorMode::kStop : MotorMode::kOff, target, limit);
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
  must_release_ = false;
  last_controlword_ = 0;
  drive_motor();
}

}  // namespace armsight::sim
