#include "protocol/mit_frames.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "protocol/little_endian.hpp"

namespace armsight {

namespace {

constexpr std::uint8_t kRead = 0x33, kWrite = 0x55, kRefresh = 0xCC, kSetZero = 0xFE, kOrderByte = 0xFF;
constexpr std::size_t kOrderBytes = 7;

/// -range … range as 0 … 2^bits - 1, to the nearest; a value in the middle of two takes the lower, as the drives' own
/// tools do with 0.
std::uint32_t to_code(double value, double least, double most, int bits) noexcept {
  const double steps = static_cast<double>((1u << bits) - 1);
  const double held = std::isfinite(value) ? std::clamp(value, least, most) : 0.0;
  return static_cast<std::uint32_t>(std::ceil((held - least) / (most - least) * steps - 0.5));
}

double from_code(std::uint32_t code, double least, double most, int bits) noexcept {
  return least + static_cast<double>(code) / static_cast<double>((1u << bits) - 1) * (most - least);
}

std::uint8_t byte(std::uint32_t value) noexcept { return static_cast<std::uint8_t>(value & 0xFF); }

CanFrame frame_to(std::uint32_t id) noexcept {
  CanFrame frame;
  frame.id = id;
  frame.size = 8;
  return frame;
}

bool is_order(const CanFrame& f) noexcept {
  return std::all_of(f.data.begin(), f.data.begin() + kOrderBytes, [](std::uint8_t b) { return b == kOrderByte; });
}

CanFrame register_frame(std::uint32_t id, std::uint8_t motor, std::uint8_t what, std::uint8_t reg,
                        std::uint32_t value) noexcept {
  CanFrame frame = frame_to(id);
  frame.data[0] = motor;
  frame.data[2] = what;
  frame.data[3] = reg;
  write_le<std::uint32_t>(frame.data.data() + 4, value);
  return frame;
}

MitCommand command_of(const CanFrame& f, const MitRanges& r) noexcept {
  const auto& d = f.data;
  const std::uint32_t q = std::uint32_t{d[0]} << 8 | d[1], dq = std::uint32_t{d[2]} << 4 | d[3] >> 4;
  const std::uint32_t kp = (d[3] & 0x0Fu) << 8 | d[4], kd = std::uint32_t{d[5]} << 4 | d[6] >> 4;
  const std::uint32_t torque = (d[6] & 0x0Fu) << 8 | d[7];
  return {from_code(q, -r.position_rad, r.position_rad, 16), from_code(dq, -r.speed_rad_s, r.speed_rad_s, 12),
          from_code(kp, 0.0, kMitMaxKp_Nm_rad, 12), from_code(kd, 0.0, kMitMaxKd_Nms_rad, 12),
          from_code(torque, -r.torque_Nm, r.torque_Nm, 12)};
}

}  // namespace

const char* to_text(MitState state) noexcept {
  switch (state) {
    case MitState::kDisabled: return "disabled";
    case MitState::kEnabled: return "enabled";
    case MitState::kSensorFault: return "encoder or sensor fault";
    case MitState::kParameterFault: return "parameter fault";
    case MitState::kOverVoltage: return "over-voltage";
    case MitState::kUnderVoltage: return "under-voltage";
    case MitState::kOverCurrent: return "over-current";
    case MitState::kPowerStageHot: return "power stage too hot";
    case MitState::kWindingHot: return "winding too hot";
    case MitState::kCommandsLost: return "commands lost: its time-out passed";
    case MitState::kOverload: return "overload";
  }
  return "unknown state";
}

CanFrame encode(const MitCommand& m, std::uint8_t motor, const MitRanges& r) noexcept {
  const std::uint32_t q = to_code(m.position_rad, -r.position_rad, r.position_rad, 16);
  const std::uint32_t dq = to_code(m.speed_rad_s, -r.speed_rad_s, r.speed_rad_s, 12);
  const std::uint32_t kp = to_code(m.kp_Nm_rad, 0.0, kMitMaxKp_Nm_rad, 12);
  const std::uint32_t kd = to_code(m.kd_Nms_rad, 0.0, kMitMaxKd_Nms_rad, 12);
  const std::uint32_t torque = to_code(m.torque_Nm, -r.torque_Nm, r.torque_Nm, 12);
  CanFrame f = frame_to(motor);
  f.data = {byte(q >> 8),       byte(q),       byte(dq >> 4),                  byte((dq & 0xF) << 4 | kp >> 8),
            byte(kp),           byte(kd >> 4), byte((kd & 0xF) << 4 | torque >> 8), byte(torque)};
  // Everything at its upper end would read as an order (…FC enables, …FE sets the zero): give up one step of Kd.
  if (is_order(f)) f.data[6] = 0xEF;
  return f;
}

CanFrame encode(MitOrder order, std::uint8_t motor) noexcept {
  CanFrame f = frame_to(motor);
  f.data.fill(kOrderByte);
  f.data[kOrderBytes] = static_cast<std::uint8_t>(order);
  return f;
}

CanFrame encode_mit_read(MitRegister reg, std::uint8_t motor) noexcept {
  return register_frame(kMitRegisterId, motor, kRead, static_cast<std::uint8_t>(reg), 0);
}

CanFrame encode_mit_write(MitRegister reg, std::uint32_t value, std::uint8_t motor) noexcept {
  return register_frame(kMitRegisterId, motor, kWrite, static_cast<std::uint8_t>(reg), value);
}

CanFrame encode_mit_refresh(std::uint8_t motor) noexcept { return register_frame(kMitRegisterId, motor, kRefresh, 0, 0); }

std::optional<MitSample> decode_mit_sample(const CanFrame& f, std::uint8_t reply_id, std::uint8_t motor,
                                           const MitRanges& r) noexcept {
  const auto& d = f.data;
  if (f.id != reply_id || f.size != 8 || (d[0] & 0x0F) != (motor & 0x0F)) return std::nullopt;
  const std::uint32_t q = std::uint32_t{d[1]} << 8 | d[2], dq = std::uint32_t{d[3]} << 4 | d[4] >> 4;
  const std::uint32_t torque = (d[4] & 0x0Fu) << 8 | d[5];
  return MitSample{static_cast<MitState>(d[0] >> 4), from_code(q, -r.position_rad, r.position_rad, 16),
                   from_code(dq, -r.speed_rad_s, r.speed_rad_s, 12), from_code(torque, -r.torque_Nm, r.torque_Nm, 12),
                   d[6], d[7]};
}

std::optional<std::uint32_t> decode_mit_answer(const CanFrame& f, std::uint8_t reply_id, std::uint8_t motor,
                                               MitRegister reg, bool is_write) noexcept {
  const auto& d = f.data;
  const bool is_it = f.id == reply_id && f.size == 8 && d[0] == motor && d[1] == 0 &&
                     d[2] == (is_write ? kWrite : kRead) && d[3] == static_cast<std::uint8_t>(reg);
  if (!is_it) return std::nullopt;
  return read_le<std::uint32_t>(d.data() + 4);
}

std::optional<MitRequest> decode_mit_request(const CanFrame& f, std::uint8_t motor, const MitRanges& ranges) noexcept {
  using Kind = MitRequest::Kind;
  MitRequest out;
  if (f.size != 8) return std::nullopt;
  if (f.id == motor) {
    if (!is_order(f)) {
      out.command = command_of(f, ranges);
      return out;
    }
    out.kind = f.data[kOrderBytes] == kSetZero ? Kind::kSetZero : Kind::kOrder;
    out.order = static_cast<MitOrder>(f.data[kOrderBytes]);
    const bool is_known = f.data[kOrderBytes] >= 0xFB && f.data[kOrderBytes] <= kSetZero;
    return is_known ? std::optional(out) : std::nullopt;
  }
  if (f.id != kMitRegisterId || f.data[0] != motor || f.data[1] != 0) return std::nullopt;
  out.reg = f.data[3];
  out.value = read_le<std::uint32_t>(f.data.data() + 4);
  switch (f.data[2]) {
    case kRead: out.kind = Kind::kRead; return out;
    case kWrite: out.kind = Kind::kWrite; return out;
    case kRefresh: out.kind = Kind::kRefresh; return out;
    default: return std::nullopt;
  }
}

CanFrame encode(const MitSample& m, std::uint8_t reply_id, std::uint8_t motor, const MitRanges& r) noexcept {
  const std::uint32_t q = to_code(m.position_rad, -r.position_rad, r.position_rad, 16);
  const std::uint32_t dq = to_code(m.speed_rad_s, -r.speed_rad_s, r.speed_rad_s, 12);
  const std::uint32_t torque = to_code(m.torque_Nm, -r.torque_Nm, r.torque_Nm, 12);
  CanFrame f = frame_to(reply_id);
  f.data = {byte(static_cast<std::uint32_t>(m.state) << 4 | (motor & 0x0Fu)), byte(q >> 8), byte(q), byte(dq >> 4),
            byte((dq & 0xF) << 4 | torque >> 8), byte(torque), m.power_stage_C, m.winding_C};
  return f;
}

CanFrame encode_mit_answer(std::uint8_t reg, std::uint32_t value, bool is_write, std::uint8_t reply_id,
                           std::uint8_t motor) noexcept {
  return register_frame(reply_id, motor, is_write ? kWrite : kRead, reg, value);
}

}  // namespace armsight
