#include "tests/arm_controller/fake_drives.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace armsight::arm::test {
namespace {

constexpr std::uint32_t key(std::uint16_t index, std::uint8_t sub) { return (std::uint32_t{index} << 8) | sub; }
constexpr int kSyncsPerHeartbeat = 25;

}  // namespace

FakeDrive::FakeDrive(std::uint8_t node, double counts_per_turn) : node_(node) {
  objects_ = {{key(0x1000, 0), 0x00020192}, {key(0x6502, 0), 0x1A1},
              {key(0x608F, 1), static_cast<std::uint32_t>(counts_per_turn)}, {key(0x608F, 2), 1},
              {key(0x6091, 1), 1}, {key(0x6091, 2), 1}, {key(0x6076, 0), 6000}};
}

std::uint32_t FakeDrive::object(std::uint16_t index, std::uint8_t sub) const {
  const auto found = objects_.find(key(index, sub));
  return found == objects_.end() ? 0 : found->second;
}

void FakeDrive::boot(std::vector<CanFrame>& answers) {
  nmt = NmtState::kPreOperational;
  if (!is_silent) answers.push_back(encode(Heartbeat{NmtState::kBootUp}, node_));
}

void FakeDrive::fail(std::uint16_t) { state = DriveState::kFault; }

std::uint16_t FakeDrive::statusword() const {
  std::uint16_t follows = heeds_target ? 1u << 12 : 0;
  if (object(0x6060, 0) == 1) follows = (controlword & 0x10) != 0 ? 1u << 12 : 0;       // set-point acknowledged
  if (object(0x6060, 0) == 6) follows = is_homed && ends_homing ? 1u << 12 | 1u << 10 : 0;  // attained, reached
  switch (state) {
    case DriveState::kSwitchOnDisabled: return 0x40;
    case DriveState::kReadyToSwitchOn: return 0x21;
    case DriveState::kSwitchedOn: return 0x23;
    case DriveState::kOperationEnabled: return static_cast<std::uint16_t>(0x27 | follows);
    case DriveState::kQuickStopActive: return 0x07;
    case DriveState::kFault: return 0x08;
    default: return 0x00;
  }
}

void FakeDrive::take(const CanFrame& frame, std::vector<CanFrame>& answers) {
  if (is_silent) return;
  if (const auto command = decode_nmt(frame); command && (command->node == node_ || command->node == 0)) {
    log.push_back("nmt " + std::to_string(static_cast<int>(command->command)));
    if (command->command == NmtCommand::kStart) nmt = NmtState::kOperational;
    if (command->command == NmtCommand::kPreOperational) nmt = NmtState::kPreOperational;
  }
  if (frame.id == kSdoRequestBase + node_) take_sdo(frame, answers);
  if (const auto set_point = decode_rpdo1(frame, node_); set_point && nmt == NmtState::kOperational) {
    if (set_point->controlword != controlword) controlwords.push_back(set_point->controlword);
    controlword = set_point->controlword;
    target_counts = set_point->target_counts;
  }
}

void FakeDrive::take_sdo(const CanFrame& frame, std::vector<CanFrame>& answers) {
  char text[32];
  const auto abort = [&](ObjectAddress object, std::uint32_t code) {
    CanFrame answer = encode(SdoReadAnswer{object, code, 4}, node_);
    answer.data[0] = 0x80;
    answers.push_back(answer);
  };
  if (const auto read = decode_sdo_read(frame, node_)) {
    const std::uint32_t k = key(read->object.index, read->object.sub);
    std::snprintf(text, sizeof text, "r %04X:%d", read->object.index, read->object.sub);
    log.push_back(text);
    if (missing.count(k)) return abort(read->object, 0x06020000);
    if (k == key(0x6061, 0)) objects_[k] = objects_[key(0x6060, 0)];
    answers.push_back(encode(SdoReadAnswer{read->object, stuck.count(k) ? stuck[k] : objects_[k], 4}, node_));
  } else if (const auto write = decode_sdo_write(frame, node_)) {
    const std::uint32_t k = key(write->object.index, write->object.sub);
    std::snprintf(text, sizeof text, "w %04X:%d %X", write->object.index, write->object.sub, write->value);
    log.push_back(text);
    if (missing.count(k)) return abort(write->object, 0x06020000);
    if (refused_values.count(k) && refused_values[k] == write->value) return abort(write->object, 0x06090030);
    objects_[k] = write->value;
    answers.push_back(encode(SdoWriteAnswer{write->object}, node_));
  }
}

void FakeDrive::step_state() {
  const std::uint16_t c = controlword & 0x8F;
  const bool reset_edge = (controlword & 0x80) && !(previous_controlword_ & 0x80);
  previous_controlword_ = controlword;
  switch (state) {
    case DriveState::kFault:
      if (reset_edge && resets_fault) state = DriveState::kSwitchOnDisabled;
      return;
    case DriveState::kSwitchOnDisabled:
      if (c == kShutdown) state = DriveState::kReadyToSwitchOn;
      return;
    case DriveState::kReadyToSwitchOn:
      if (c == kSwitchOn || c == kEnableOperation) state = DriveState::kSwitchedOn;
      else if (c != kShutdown) state = DriveState::kSwitchOnDisabled;
      return;
    case DriveState::kSwitchedOn:
      if (c == kEnableOperation && reaches_enabled) state = DriveState::kOperationEnabled;
      else if (c == kShutdown) state = DriveState::kReadyToSwitchOn;
      else if (c == kDisableVoltage) state = DriveState::kSwitchOnDisabled;
      return;
    case DriveState::kOperationEnabled:
      if (c == kQuickStop) state = DriveState::kQuickStopActive;
      else if (c == kShutdown) state = DriveState::kReadyToSwitchOn;
      else if (c == kSwitchOn) state = DriveState::kSwitchedOn;
      else if (c == kDisableVoltage) state = DriveState::kSwitchOnDisabled;
      return;
    case DriveState::kQuickStopActive:
      if (c == kEnableOperation && has_transition_16) state = DriveState::kOperationEnabled;
      else if (c == kDisableVoltage) state = DriveState::kSwitchOnDisabled;
      return;
    default: return;
  }
}

void FakeDrive::move() {
  const bool bit_4_rose = (controlword & 0x10) != 0 && !bit_4_was_up_;
  bit_4_was_up_ = (controlword & 0x10) != 0;
  if (state != DriveState::kOperationEnabled) return;
  if (object(0x6060, 0) == 9) {
    position_counts += target_counts * 0.004;
    return;
  }
  if (object(0x6060, 0) == 6) {
    if (bit_4_rose) position_counts = 0.0, is_homed = true;
    return;
  }
  if (object(0x6060, 0) == 1) {
    if (bit_4_rose) profile_targets.push_back(target_counts);
    if (!profile_targets.empty())
      position_counts += std::clamp(profile_targets.back() - position_counts, -200.0, 200.0);
    return;
  }
  position_counts += follow_per_cycle * (target_counts + residual_counts - position_counts);
  if (wall_counts) position_counts = std::min(position_counts, *wall_counts);
}

void FakeDrive::on_sync(std::vector<CanFrame>& answers) {
  if (is_silent) return;
  ++syncs_;
  if (nmt == NmtState::kOperational) {
    step_state();
    move();
    if (sends_feedback)
      answers.push_back(
          encode(Tpdo1{statusword(), static_cast<std::int32_t>(std::lround(position_counts)), 100}, node_));
  }
  if (sends_heartbeat && syncs_ % kSyncsPerHeartbeat == 0) answers.push_back(encode(Heartbeat{nmt}, node_));
}

FakeBus::FakeBus(std::vector<double> counts_per_turn) {
  for (std::size_t i = 0; i < counts_per_turn.size(); ++i)
    drives_.emplace_back(static_cast<std::uint8_t>(i + 1), counts_per_turn[i]);
}

SendResult FakeBus::send(const CanFrame& frame) noexcept {
  if (is_full) return SendResult::kQueueFull;
  sent.push_back(frame);
  std::vector<CanFrame> answers;
  if (frame.id == kSyncId) {
    queue(frame, true);
    for (FakeDrive& drive : drives_) drive.on_sync(answers);
  } else {
    for (FakeDrive& drive : drives_) drive.take(frame, answers);
  }
  for (const CanFrame& answer : answers) queue(answer);
  return SendResult::kSent;
}

bool FakeBus::receive(BusFrame& frame) noexcept {
  if (incoming_.empty()) return false;
  frame = incoming_.front();
  incoming_.pop_front();
  return true;
}

BusErrors FakeBus::take_errors() noexcept {
  const BusErrors taken = errors;
  errors = {};
  return taken;
}

}  // namespace armsight::arm::test
