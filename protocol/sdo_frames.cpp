// Expedited SDO of CiA 301 ↔ 8 bytes: command, index, sub-index, up to four data bytes (controller.md §4.2).
#include <algorithm>

#include "protocol/can_frames.hpp"
#include "protocol/little_endian.hpp"

namespace armsight {

namespace {

// Command bytes. Expedited transfers with the size indicated: base | (4 - size) << 2 | 0b11.
constexpr std::uint8_t kReadRequest = 0x40, kReadAnswer = 0x43, kWriteRequest = 0x23, kWriteAnswer = 0x60,
                       kAbort = 0x80;
constexpr std::uint8_t kReadAnswerUnsized = 0x42;  ///< expedited, size not indicated: the asker knows it

constexpr std::uint8_t sized(std::uint8_t base, std::uint8_t size) noexcept {
  return static_cast<std::uint8_t>(base | (4 - std::clamp<int>(size, 1, 4)) << 2);
}

CanFrame sdo_frame(std::uint32_t id, std::uint8_t command, const ObjectAddress& object, std::uint32_t data) noexcept {
  CanFrame f;
  f.id = id;
  f.size = 8;
  f.data[0] = command;
  write_le<std::uint16_t>(f.data.data() + 1, object.index);
  f.data[3] = object.sub;
  write_le<std::uint32_t>(f.data.data() + 4, data);
  return f;
}

/// The value cut to its size: what a transfer of so many bytes carries.
constexpr std::uint32_t cut(std::uint32_t value, std::uint8_t size) noexcept {
  return size >= 4 ? value : value & ((1U << (8 * std::max<int>(size, 1))) - 1U);
}

bool is_sdo(const CanFrame& f, std::uint32_t base, std::uint8_t node) noexcept {
  return node >= 1 && node <= 127 && f.id == base + node && f.size == 8;
}

ObjectAddress object_of(const CanFrame& f) noexcept { return {read_le<std::uint16_t>(f.data.data() + 1), f.data[3]}; }
std::uint32_t data_of(const CanFrame& f) noexcept { return read_le<std::uint32_t>(f.data.data() + 4); }

/// Data bytes of an expedited command with the size indicated, 0 if it is none.
std::uint8_t size_of(std::uint8_t command, std::uint8_t base) noexcept {
  for (std::uint8_t size = 1; size <= 4; ++size)
    if (command == sized(base, size)) return size;
  return 0;
}

}  // namespace

CanFrame encode(const SdoRead& m, std::uint8_t node) noexcept {
  return sdo_frame(kSdoRequestBase + node, kReadRequest, m.object, 0);
}
CanFrame encode(const SdoWrite& m, std::uint8_t node) noexcept {
  return sdo_frame(kSdoRequestBase + node, sized(kWriteRequest, m.size), m.object, cut(m.value, m.size));
}
CanFrame encode(const SdoReadAnswer& m, std::uint8_t node) noexcept {
  return sdo_frame(kSdoAnswerBase + node, sized(kReadAnswer, m.size), m.object, cut(m.value, m.size));
}
CanFrame encode(const SdoWriteAnswer& m, std::uint8_t node) noexcept {
  return sdo_frame(kSdoAnswerBase + node, kWriteAnswer, m.object, 0);
}
CanFrame encode_request_abort(const SdoAbort& m, std::uint8_t node) noexcept {
  return sdo_frame(kSdoRequestBase + node, kAbort, m.object, m.code);
}
CanFrame encode_answer_abort(const SdoAbort& m, std::uint8_t node) noexcept {
  return sdo_frame(kSdoAnswerBase + node, kAbort, m.object, m.code);
}

std::optional<SdoRead> decode_sdo_read(const CanFrame& f, std::uint8_t node) noexcept {
  if (!is_sdo(f, kSdoRequestBase, node) || f.data[0] != kReadRequest) return std::nullopt;
  return SdoRead{object_of(f)};
}

std::optional<SdoWrite> decode_sdo_write(const CanFrame& f, std::uint8_t node) noexcept {
  const std::uint8_t size = size_of(f.data[0], kWriteRequest);
  if (!is_sdo(f, kSdoRequestBase, node) || size == 0) return std::nullopt;
  return SdoWrite{object_of(f), cut(data_of(f), size), size};
}

std::optional<SdoReadAnswer> decode_sdo_read_answer(const CanFrame& f, std::uint8_t node) noexcept {
  const std::uint8_t size = f.data[0] == kReadAnswerUnsized ? 4 : size_of(f.data[0], kReadAnswer);
  if (!is_sdo(f, kSdoAnswerBase, node) || size == 0) return std::nullopt;
  return SdoReadAnswer{object_of(f), cut(data_of(f), size), size};
}

std::optional<SdoWriteAnswer> decode_sdo_write_answer(const CanFrame& f, std::uint8_t node) noexcept {
  if (!is_sdo(f, kSdoAnswerBase, node) || f.data[0] != kWriteAnswer) return std::nullopt;
  return SdoWriteAnswer{object_of(f)};
}

std::optional<SdoAbort> decode_sdo_answer_abort(const CanFrame& f, std::uint8_t node) noexcept {
  if (!is_sdo(f, kSdoAnswerBase, node) || f.data[0] != kAbort) return std::nullopt;
  return SdoAbort{object_of(f), data_of(f)};
}

const char* sdo_abort_text(std::uint32_t code) noexcept {
  switch (code) {
    case 0x05030000: return "toggle bit did not alternate";
    case 0x05040000: return "SDO time-out";
    case 0x05040001: return "command not valid or unknown";
    case 0x05040005: return "out of memory";
    case 0x06010000: return "access to the object is not supported";
    case 0x06010001: return "read of a write-only object";
    case 0x06010002: return "write to a read-only object";
    case 0x06020000: return "no such object";
    case 0x06040041: return "object cannot be mapped to a PDO";
    case 0x06040042: return "mapping exceeds the length of a PDO";
    case 0x06040043: return "parameters are incompatible";
    case 0x06040047: return "incompatible inside the device";
    case 0x06060000: return "access failed: hardware error";
    case 0x06070010: return "length of the value does not match";
    case 0x06070012: return "value too long";
    case 0x06070013: return "value too short";
    case 0x06090011: return "no such sub-index";
    case 0x06090030: return "value out of range";
    case 0x06090031: return "value too high";
    case 0x06090032: return "value too low";
    case 0x06090036: return "maximum is below minimum";
    case 0x060A0023: return "resource not available";
    case 0x08000000: return "general error";
    case 0x08000020: return "value cannot be stored";
    case 0x08000021: return "value cannot be stored: local control";
    case 0x08000022: return "value cannot be stored in the present device state";
    case 0x08000023: return "no object dictionary";
    case 0x08000024: return "no data available";
    default: return "unknown SDO abort code";
  }
}

}  // namespace armsight
