#include "protocol/can_frames.hpp"

#include "protocol/little_endian.hpp"

namespace armsight {

namespace {

constexpr CanFrame make_frame(std::uint32_t id, std::uint8_t size) noexcept {
  CanFrame f;
  f.id = id;
  f.size = size;
  return f;
}

/// Is this the frame `base + node`, with exactly `size` bytes?
constexpr bool fits(const CanFrame& f, std::uint32_t base, std::uint8_t node, std::uint8_t size) noexcept {
  return node >= 1 && node <= 127 && f.id == base + node && f.size == size;
}

template <std::integral T>
void put(CanFrame& f, std::size_t at, std::type_identity_t<T> value) noexcept {
  write_le<T>(f.data.data() + at, value);
}

template <std::integral T>
T get(const CanFrame& f, std::size_t at) noexcept {
  return read_le<T>(f.data.data() + at);
}

}  // namespace

CanFrame encode(const Nmt& m) noexcept {
  CanFrame f = make_frame(kNmtId, 2);
  put<std::uint8_t>(f, 0, static_cast<std::uint8_t>(m.command));
  put<std::uint8_t>(f, 1, m.node);
  return f;
}

CanFrame encode(const Sync& m) noexcept {
  CanFrame f = make_frame(kSyncId, m.counter == 0 ? 0 : 1);
  put<std::uint8_t>(f, 0, m.counter);
  return f;
}

CanFrame encode(const Emcy& m, std::uint8_t node) noexcept {
  CanFrame f = make_frame(kEmcyBase + node, 8);
  put<std::uint16_t>(f, 0, m.code);
  put<std::uint8_t>(f, 2, m.error_register);
  return f;
}

CanFrame encode(const Heartbeat& m, std::uint8_t node) noexcept {
  CanFrame f = make_frame(kHeartbeatBase + node, 1);
  put<std::uint8_t>(f, 0, static_cast<std::uint8_t>(m.state));
  return f;
}

CanFrame encode(const Tpdo1& m, std::uint8_t node) noexcept {
  CanFrame f = make_frame(kTpdo1Base + node, 8);
  put<std::uint16_t>(f, 0, m.statusword);
  put<std::int32_t>(f, 2, m.position_counts);
  put<std::int16_t>(f, 6, m.torque);
  return f;
}

CanFrame encode(const Rpdo1& m, std::uint8_t node) noexcept {
  CanFrame f = make_frame(kRpdo1Base + node, 8);
  put<std::uint16_t>(f, 0, m.controlword);
  put<std::int32_t>(f, 2, m.target_counts);
  put<std::int16_t>(f, 6, m.torque_offset);
  return f;
}

std::optional<Nmt> decode_nmt(const CanFrame& f) noexcept {
  if (f.id != kNmtId || f.size != 2) return std::nullopt;
  const auto command = static_cast<NmtCommand>(f.data[0]);
  switch (command) {
    case NmtCommand::kStart:
    case NmtCommand::kStop:
    case NmtCommand::kPreOperational:
    case NmtCommand::kResetNode:
    case NmtCommand::kResetCommunication: return Nmt{command, f.data[1]};
  }
  return std::nullopt;
}

std::optional<Sync> decode_sync(const CanFrame& f) noexcept {
  if (f.id != kSyncId || f.size > 1) return std::nullopt;
  return Sync{f.size == 1 ? f.data[0] : std::uint8_t{0}};
}

std::optional<Emcy> decode_emcy(const CanFrame& f, std::uint8_t node) noexcept {
  if (!fits(f, kEmcyBase, node, 8)) return std::nullopt;
  return Emcy{get<std::uint16_t>(f, 0), f.data[2]};
}

std::optional<Heartbeat> decode_heartbeat(const CanFrame& f, std::uint8_t node) noexcept {
  if (!fits(f, kHeartbeatBase, node, 1)) return std::nullopt;
  const auto state = static_cast<NmtState>(f.data[0]);
  switch (state) {
    case NmtState::kBootUp:
    case NmtState::kStopped:
    case NmtState::kOperational:
    case NmtState::kPreOperational: return Heartbeat{state};
  }
  return std::nullopt;
}

std::optional<Tpdo1> decode_tpdo1(const CanFrame& f, std::uint8_t node) noexcept {
  if (!fits(f, kTpdo1Base, node, 8)) return std::nullopt;
  return Tpdo1{get<std::uint16_t>(f, 0), get<std::int32_t>(f, 2), get<std::int16_t>(f, 6)};
}

std::optional<Rpdo1> decode_rpdo1(const CanFrame& f, std::uint8_t node) noexcept {
  if (!fits(f, kRpdo1Base, node, 8)) return std::nullopt;
  return Rpdo1{get<std::uint16_t>(f, 0), get<std::int32_t>(f, 2), get<std::int16_t>(f, 6)};
}

DriveState drive_state(std::uint16_t statusword) noexcept {
  switch (statusword & 0x4F) {
    case 0x00: return DriveState::kNotReady;
    case 0x40: return DriveState::kSwitchOnDisabled;
    case 0x0F: return DriveState::kFaultReaction;
    case 0x08: return DriveState::kFault;
    default: break;
  }
  switch (statusword & 0x6F) {
    case 0x21: return DriveState::kReadyToSwitchOn;
    case 0x23: return DriveState::kSwitchedOn;
    case 0x27: return DriveState::kOperationEnabled;
    case 0x07: return DriveState::kQuickStopActive;
    default: return DriveState::kUnknown;
  }
}

const char* to_text(DriveState state) noexcept {
  switch (state) {
    case DriveState::kNotReady: return "not ready to switch on";
    case DriveState::kSwitchOnDisabled: return "switch on disabled";
    case DriveState::kReadyToSwitchOn: return "ready to switch on";
    case DriveState::kSwitchedOn: return "switched on";
    case DriveState::kOperationEnabled: return "operation enabled";
    case DriveState::kQuickStopActive: return "quick stop active";
    case DriveState::kFaultReaction: return "fault reaction active";
    case DriveState::kFault: return "fault";
    case DriveState::kUnknown: break;
  }
  return "unknown";
}

}  // namespace armsight
