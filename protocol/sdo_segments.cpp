#include "protocol/sdo_segments.hpp"

#include <algorithm>

#include "protocol/little_endian.hpp"

namespace armsight {

namespace {

constexpr std::uint8_t kSegmentedWrite = 0x21, kSegmentedAnswer = 0x41, kNextSegment = 0x60, kSegmentDone = 0x20,
                       kAbortCommand = 0x80, kToggle = 0x10, kIsLast = 0x01, kSizeKnown = 0x01;

CanFrame segment_frame(std::uint32_t id, std::uint8_t command) noexcept {
  CanFrame f;
  f.id = id;
  f.size = 8;
  f.data[0] = command;
  return f;
}

CanFrame start_frame(std::uint32_t id, std::uint8_t command, const SdoSegmentedStart& m) noexcept {
  CanFrame f = segment_frame(id, command);
  write_le<std::uint16_t>(f.data.data() + 1, m.object.index);
  f.data[3] = m.object.sub;
  write_le<std::uint32_t>(f.data.data() + 4, m.total_bytes);
  return f;
}

CanFrame data_frame(std::uint32_t id, const SdoSegment& m) noexcept {
  const int unused = 7 - std::min<int>(m.size, 7);
  CanFrame f = segment_frame(id, static_cast<std::uint8_t>((m.toggle ? kToggle : 0) | unused << 1 | (m.is_last ? kIsLast : 0)));
  std::copy_n(m.data.begin(), 7 - unused, f.data.begin() + 1);
  return f;
}

bool is_of(const CanFrame& f, std::uint32_t base, std::uint8_t node) noexcept {
  return node >= 1 && node <= 127 && f.id == base + node && f.size == 8;
}

/// Bit 0 of the command says whether the size is told; 0: it is not, the last segment ends it.
std::optional<SdoSegmentedStart> decode_start(const CanFrame& f, std::uint8_t command) noexcept {
  if ((f.data[0] | kSizeKnown) != command) return std::nullopt;
  const std::uint32_t total = (f.data[0] & kSizeKnown) != 0 ? read_le<std::uint32_t>(f.data.data() + 4) : 0;
  return SdoSegmentedStart{{read_le<std::uint16_t>(f.data.data() + 1), f.data[3]}, total};
}

std::optional<SdoSegment> decode_segment(const CanFrame& f) noexcept {
  if ((f.data[0] & 0xE0) != 0) return std::nullopt;
  SdoSegment m;
  m.toggle = (f.data[0] & kToggle) != 0;
  m.is_last = (f.data[0] & kIsLast) != 0;
  m.size = static_cast<std::uint8_t>(7 - (f.data[0] >> 1 & 7));
  std::copy_n(f.data.begin() + 1, m.size, m.data.begin());
  return m;
}

}  // namespace

CanFrame encode_request(const SdoSegmentedStart& m, std::uint8_t node) noexcept {
  return start_frame(kSdoRequestBase + node, kSegmentedWrite, m);
}
CanFrame encode_answer(const SdoSegmentedStart& m, std::uint8_t node) noexcept {
  return start_frame(kSdoAnswerBase + node, kSegmentedAnswer, m);
}
CanFrame encode_request(const SdoSegment& m, std::uint8_t node) noexcept { return data_frame(kSdoRequestBase + node, m); }
CanFrame encode_answer(const SdoSegment& m, std::uint8_t node) noexcept { return data_frame(kSdoAnswerBase + node, m); }
CanFrame encode(const SdoSegmentRequest& m, std::uint8_t node) noexcept {
  return segment_frame(kSdoRequestBase + node, static_cast<std::uint8_t>(kNextSegment | (m.toggle ? kToggle : 0)));
}
CanFrame encode(const SdoSegmentConfirmation& m, std::uint8_t node) noexcept {
  return segment_frame(kSdoAnswerBase + node, static_cast<std::uint8_t>(kSegmentDone | (m.toggle ? kToggle : 0)));
}

std::optional<SdoSegmentedStart> decode_sdo_segmented_write(const CanFrame& f, std::uint8_t node) noexcept {
  return is_of(f, kSdoRequestBase, node) ? decode_start(f, kSegmentedWrite) : std::nullopt;
}
std::optional<SdoSegmentedStart> decode_sdo_segmented_answer(const CanFrame& f, std::uint8_t node) noexcept {
  return is_of(f, kSdoAnswerBase, node) ? decode_start(f, kSegmentedAnswer) : std::nullopt;
}
std::optional<SdoSegment> decode_sdo_request_segment(const CanFrame& f, std::uint8_t node) noexcept {
  return is_of(f, kSdoRequestBase, node) ? decode_segment(f) : std::nullopt;
}
std::optional<SdoSegment> decode_sdo_answer_segment(const CanFrame& f, std::uint8_t node) noexcept {
  return is_of(f, kSdoAnswerBase, node) ? decode_segment(f) : std::nullopt;
}
std::optional<SdoSegmentRequest> decode_sdo_segment_request(const CanFrame& f, std::uint8_t node) noexcept {
  if (!is_of(f, kSdoRequestBase, node) || (f.data[0] & ~kToggle) != kNextSegment) return std::nullopt;
  return SdoSegmentRequest{(f.data[0] & kToggle) != 0};
}
std::optional<SdoSegmentConfirmation> decode_sdo_segment_confirmation(const CanFrame& f, std::uint8_t node) noexcept {
  if (!is_of(f, kSdoAnswerBase, node) || (f.data[0] & ~kToggle) != kSegmentDone) return std::nullopt;
  return SdoSegmentConfirmation{(f.data[0] & kToggle) != 0};
}
std::optional<SdoAbort> decode_sdo_request_abort(const CanFrame& f, std::uint8_t node) noexcept {
  if (!is_of(f, kSdoRequestBase, node) || f.data[0] != kAbortCommand) return std::nullopt;
  return SdoAbort{{read_le<std::uint16_t>(f.data.data() + 1), f.data[3]}, read_le<std::uint32_t>(f.data.data() + 4)};
}

}  // namespace armsight
