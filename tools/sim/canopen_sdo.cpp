// CanopenDevice's SDO server: expedited reads and writes, and the order in which PDOs may be changed
// (controller.md §4.3): COB-ID invalid → mapping count 0 → entries → count → COB-ID valid.
#include "tools/sim/canopen_device.hpp"

namespace armsight::sim {

namespace {

constexpr std::uint32_t kPdoOff = 0x80000000;
constexpr std::uint32_t kRtrBit = 0x40000000;
constexpr std::uint8_t kMaxMappable = 8;
constexpr std::uint8_t kRequestAbort = 0x80;

bool is_pdo_communication(std::uint16_t index) { return index == 0x1400 || index == 0x1800; }
bool is_pdo_mapping(std::uint16_t index) { return index == 0x1600 || index == 0x1A00; }

}  // namespace

void CanopenDevice::on_sdo(const CanFrame& frame, Time now) {
  if (const auto read = decode_sdo_read(frame, node_)) return on_read(read->object, now);
  if (const auto write = decode_sdo_write(frame, node_)) return on_write(*write, now);
  if (frame.size != 8 || frame.data[0] == kRequestAbort) return;
  const auto index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
  answer_abort({index, frame.data[3]}, kBadCommand, now);
}

void CanopenDevice::on_read(ObjectAddress object, Time now) {
  const Object* found = objects_.find(object);
  if (found == nullptr) return answer_abort(object, objects_.missing(object), now);
  send_(encode(SdoReadAnswer{object, value_of(object), found->size}, node_), now);
}

void CanopenDevice::on_write(const SdoWrite& write, Time now) {
  std::uint32_t code = objects_.forbids_write(write.object, write.size);
  if (code == 0) code = judge_communication(write);
  if (code == 0) code = judge(write.object, write.value);
  if (code != 0) return answer_abort(write.object, code, now);
  objects_.set(write.object, write.value);
  if (write.object == ObjectAddress{0x1017, 0}) send_heartbeat(now);
  send_(encode(SdoWriteAnswer{write.object}, node_), now);
}

void CanopenDevice::answer_abort(ObjectAddress object, std::uint32_t code, Time now) {
  send_(encode_answer_abort(SdoAbort{object, code}, node_), now);
}

std::uint32_t CanopenDevice::judge_communication(const SdoWrite& write) const {
  const auto [index, sub] = write.object;
  if (index == 0x1005 && (write.value & 0x7FF) == 0) return kBadValue;
  if (index == 0x1019 && (write.value == 1 || write.value > 240)) return kBadValue;
  if ((index == 0x1401 || index == 0x1801) && (write.value & kPdoOff) == 0) return kBadValue;
  if (is_pdo_mapping(index)) return judge_mapping(write);
  if (!is_pdo_communication(index)) return 0;
  if (sub == 1) {
    const std::uint32_t now = objects_.get(index, 1);
    const bool moves_while_valid = pdo_is_valid(index) && (write.value & kPdoOff) == 0 &&
                                   (now & ~kRtrBit) != (write.value & ~kRtrBit);
    const std::uint32_t id = write.value & 0x7FF;
    return moves_while_valid ? kBadState : id < 0x181 || id > 0x57F ? kBadValue : 0;
  }
  if (sub == 2) return write.value == 0 || (write.value > 240 && write.value < 254) ? kBadValue : 0;
  return 0;
}

std::uint32_t CanopenDevice::judge_mapping(const SdoWrite& write) const {
  const auto [index, sub] = write.object;
  const auto communication = static_cast<std::uint16_t>(index - 0x200);
  if (pdo_is_valid(communication)) return kBadState;
  if (sub == 0) return judge_count(index, write.value);
  if (objects_.get(index) != 0) return kUnsupportedAccess;
  const auto mapped = static_cast<std::uint16_t>(write.value >> 16);
  const Object* object = objects_.find({mapped, static_cast<std::uint8_t>(write.value >> 8)});
  const bool may = index == 0x1600 ? is_receive_mappable(mapped) : is_transmit_mappable(mapped);
  return object != nullptr && may && (write.value & 0xFF) == 8u * object->size ? 0 : kCannotMap;
}

std::uint32_t CanopenDevice::judge_count(std::uint16_t mapping, std::uint32_t count) const {
  if (count > kMaxMappable) return kMappingTooLong;
  std::uint32_t bits = 0;
  for (std::uint8_t i = 1; i <= count; ++i) {
    const std::uint32_t entry = objects_.get(mapping, i);
    if (entry == 0) return kCannotMap;
    bits += entry & 0xFF;
  }
  return bits > 64 ? kMappingTooLong : 0;
}

}  // namespace armsight::sim
