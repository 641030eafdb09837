#include "arm_controller/sdo_client.hpp"

#include <algorithm>
#include <cassert>

namespace armsight::arm {

void SdoClient::start_write(ObjectAddress object, std::uint32_t value, std::uint8_t size) noexcept {
  std::array<std::uint8_t, 4> bytes{};
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
  start(object, true, std::span(bytes).first(std::clamp<std::size_t>(size, 1, 4)));
}

void SdoClient::start(ObjectAddress object, bool is_write, std::span<const std::uint8_t> bytes) noexcept {
  assert(bytes.size() <= kMaxBytes);
  object_ = object;
  is_write_ = is_write;
  count_ = std::min(bytes.size(), kMaxBytes);
  std::copy_n(bytes.begin(), count_, bytes_.begin());
  attempts_ = 0;
  abort_to_send_.reset();
  result_ = SdoResult::kPending;
  begin_attempt();
}

void SdoClient::begin_attempt() noexcept {
  step_ = Step::kInitiate;
  is_sent_ = toggle_ = false;
  done_ = 0;
  announced_ = 0;
  if (!is_write_) count_ = 0;
}

std::uint32_t SdoClient::value() const noexcept {
  if (result_ == SdoResult::kAborted) return abort_code_;
  std::uint32_t value = 0;
  for (std::size_t i = std::min<std::size_t>(count_, 4); i > 0; --i) value = value << 8 | bytes_[i - 1];
  return value;
}

void SdoClient::receive(const CanFrame& frame, std::uint8_t node) noexcept {
  if (result_ != SdoResult::kPending || !is_sent_) return;
  if (const auto abort = decode_sdo_answer_abort(frame, node); abort && abort->object == object_) {
    abort_code_ = abort->code;
    result_ = SdoResult::kAborted;
  } else if (step_ == Step::kInitiate) {
    answer_initiation(frame, node);
  } else if (frame.id == kSdoAnswerBase + node && !abort) {
    answer_segment(frame, node);
  }
}

// An answer to an earlier, repeated request may still come: what does not fit is not for us.
void SdoClient::answer_initiation(const CanFrame& frame, std::uint8_t node) noexcept {
  if (is_write_) {
    const auto answer = decode_sdo_write_answer(frame, node);
    if (!answer || answer->object != object_) return;
    if (count_ <= 4) result_ = SdoResult::kDone;
    else go_on(Step::kDownload);
  } else if (const auto answer = decode_sdo_read_answer(frame, node); answer && answer->object == object_) {
    count_ = answer->size;
    for (std::size_t i = 0; i < 4; ++i) bytes_[i] = static_cast<std::uint8_t>(answer->value >> (8 * i));
    result_ = SdoResult::kDone;
  } else if (const auto begin = decode_sdo_segmented_answer(frame, node); begin && begin->object == object_) {
    announced_ = begin->total_bytes;
    if (announced_ > kMaxBytes) fail(kSdoOutOfMemory);
    else go_on(Step::kUpload);
  }
}

// Segments name no object: one that does not fit breaks the transfer.
void SdoClient::answer_segment(const CanFrame& frame, std::uint8_t node) noexcept {
  if (step_ == Step::kUpload) {
    const auto segment = decode_sdo_answer_segment(frame, node);
    return segment ? take_segment(*segment) : fail(kSdoBadCommand);
  }
  const auto confirmation = decode_sdo_segment_confirmation(frame, node);
  if (!confirmation) return fail(kSdoBadCommand);
  if (confirmation->toggle != toggle_) return fail(kSdoToggleError);
  done_ += next_segment().size;
  if (done_ == count_) result_ = SdoResult::kDone;
  else {
    toggle_ = !toggle_;
    go_on(Step::kDownload);
  }
}

void SdoClient::take_segment(const SdoSegment& segment) noexcept {
  if (segment.toggle != toggle_) return fail(kSdoToggleError);
  if (count_ + segment.size > kMaxBytes) return fail(kSdoOutOfMemory);
  std::copy_n(segment.data.begin(), segment.size, bytes_.begin() + static_cast<std::ptrdiff_t>(count_));
  count_ += segment.size;
  if (!segment.is_last) {
    toggle_ = !toggle_;
    return go_on(Step::kUpload);
  }
  if (announced_ != 0 && announced_ != count_) return fail(kSdoWrongLength);
  result_ = SdoResult::kDone;
}

void SdoClient::go_on(Step step) noexcept {
  step_ = step;
  is_sent_ = false;
}

/// We give this attempt up and tell the server; out of memory stays out of memory.
void SdoClient::fail(std::uint32_t code) noexcept {
  abort_to_send_ = code;
  if (code == kSdoOutOfMemory || attempts_ == kAttempts) {
    abort_code_ = code;
    result_ = SdoResult::kAborted;
    return;
  }
  begin_attempt();
}

std::optional<CanFrame> SdoClient::request_to_send(std::uint8_t node, Time now) noexcept {
  if (result_ == SdoResult::kPending && is_sent_ && now - sent_ >= kTimeout) {
    if (step_ != Step::kInitiate) abort_to_send_ = kSdoTimeout;  // the server still waits within the transfer
    if (attempts_ == kAttempts) result_ = SdoResult::kTimedOut;
    else begin_attempt();
  }
  if (abort_to_send_) {
    const CanFrame frame = encode_request_abort({object_, *abort_to_send_}, node);
    abort_to_send_.reset();
    return frame;
  }
  if (result_ != SdoResult::kPending || is_sent_) return std::nullopt;
  if (step_ == Step::kInitiate) ++attempts_;
  is_sent_ = true;
  sent_ = now;
  return next_request(node);
}

CanFrame SdoClient::next_request(std::uint8_t node) const noexcept {
  if (step_ == Step::kUpload) return encode(SdoSegmentRequest{toggle_}, node);
  if (step_ == Step::kDownload) return encode_request(next_segment(), node);
  if (!is_write_) return encode(SdoRead{object_}, node);
  if (count_ <= 4) return encode(SdoWrite{object_, value(), static_cast<std::uint8_t>(count_)}, node);
  return encode_request(SdoSegmentedStart{object_, static_cast<std::uint32_t>(count_)}, node);
}

SdoSegment SdoClient::next_segment() const noexcept {
  SdoSegment segment;
  segment.toggle = toggle_;
  segment.size = static_cast<std::uint8_t>(std::min<std::size_t>(7, count_ - done_));
  segment.is_last = done_ + segment.size == count_;
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(done_), segment.size, segment.data.begin());
  return segment;
}

}  // namespace armsight::arm
