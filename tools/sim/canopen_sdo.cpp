// CanopenDevice's SDO server: expedited reads and writes, texts in segments, and the order in which PDOs may be changed
// (controller.md §4.3): COB-ID invalid → mapping count 0 → entries → count → COB-ID valid.
#include <algorithm>

#include "tools/sim/canopen_device.hpp"

namespace armsight::sim {

namespace {

constexpr std::uint32_t kPdoOff = 0x80000000;
constexpr std::uint32_t kRtrBit = 0x40000000;
constexpr std::uint8_t kMaxMappable = 8;

bool is_pdo_communication(std::uint16_t index) { return index == 0x1400 || index == 0x1800; }
bool is_pdo_mapping(std::uint16_t index) { return index == 0x1600 || index == 0x1A00; }

}  // namespace

void CanopenDevice::on_sdo(const CanFrame& frame, Time now) {
  if (decode_sdo_request_abort(frame, node_)) return transfer_.reset();
  if (transfer_ && on_segment(frame, now)) return;
  transfer_.reset();  // a new request ends what came before
  if (const auto read = decode_sdo_read(frame, node_)) return on_read(read->object, now);
  if (const auto write = decode_sdo_write(frame, node_)) return on_write(*write, now);
  if (const auto start = decode_sdo_segmented_write(frame, node_)) return on_segmented_write(*start, now);
  if (frame.size != 8) return;
  const auto index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
  answer_abort({index, frame.data[3]}, kBadCommand, now);
}

bool CanopenDevice::on_segment(const CanFrame& frame, Time now) {
  if (const auto request = decode_sdo_segment_request(frame, node_); request && !transfer_->is_download) {
    on_segment_request(*request, now);
    return true;
  }
  const auto segment = decode_sdo_request_segment(frame, node_);
  if (segment && transfer_->is_download) on_written_segment(*segment, now);
  return segment && (!transfer_ || transfer_->is_download);
}

void CanopenDevice::end_transfer(std::uint32_t code, Time now) {
  if (code != 0) answer_abort(transfer_->object, code, now);
  transfer_.reset();
}

void CanopenDevice::on_segmented_write(const SdoSegmentedStart& start, Time now) {
  const TextObject* text = objects_.find_text(start.object);
  const std::uint32_t missing = objects_.find(start.object) != nullptr ? kTooLong : objects_.missing(start.object);
  if (text == nullptr) return answer_abort(start.object, missing, now);
  if (text->max_bytes == 0) return answer_abort(start.object, kWriteToReadOnly, now);
  if (start.total_bytes > text->max_bytes) return answer_abort(start.object, kTooLong, now);
  transfer_ = Transfer{true, start.object, {}, start.total_bytes, false};
  send_(encode(SdoWriteAnswer{start.object}, node_), now);
}

void CanopenDevice::on_written_segment(const SdoSegment& segment, Time now) {
  if (segment.toggle != transfer_->toggle) return end_transfer(kSdoToggleError, now);
  transfer_->bytes.append(segment.data.begin(), segment.data.begin() + segment.size);
  TextObject* text = objects_.find_text(transfer_->object);
  if (transfer_->bytes.size() > text->max_bytes) return end_transfer(kTooLong, now);
  const bool is_cut = transfer_->announced != 0 && transfer_->bytes.size() != transfer_->announced;
  if (segment.is_last && is_cut) return end_transfer(kSdoWrongLength, now);
  send_(encode(SdoSegmentConfirmation{segment.toggle}, node_), now);
  transfer_->toggle = !transfer_->toggle;
  if (!segment.is_last) return;
  text->text = transfer_->bytes;
  end_transfer(0, now);
}

void CanopenDevice::on_segment_request(const SdoSegmentRequest& request, Time now) {
  if (request.toggle != transfer_->toggle) return end_transfer(kSdoToggleError, now);
  SdoSegment segment;
  segment.toggle = request.toggle;
  segment.size = static_cast<std::uint8_t>(std::min<std::size_t>(7, transfer_->bytes.size()));
  segment.is_last = segment.size == transfer_->bytes.size();
  std::copy_n(transfer_->bytes.begin(), segment.size, segment.data.begin());
  transfer_->bytes.erase(0, segment.size);
  transfer_->toggle = !transfer_->toggle;
  send_(encode_answer(segment, node_), now);
  if (segment.is_last) end_transfer(0, now);
}

void CanopenDevice::on_read(ObjectAddress object, Time now) {
  if (is_missing(object)) return answer_abort(object, kNoSuchObject, now);
  if (const TextObject* text = objects_.find_text(object)) {
    transfer_ = Transfer{false, object, text->text, 0, false};
    return send_(encode_answer(SdoSegmentedStart{object, static_cast<std::uint32_t>(text->text.size())}, node_), now);
  }
  const Object* found = objects_.find(object);
  if (found == nullptr) return answer_abort(object, objects_.missing(object), now);
  send_(encode(SdoReadAnswer{object, value_of(object), found->size}, node_), now);
}

void CanopenDevice::on_write(const SdoWrite& write, Time now) {
  if (is_missing(write.object)) return answer_abort(write.object, kNoSuchObject, now);
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
