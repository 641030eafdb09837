#include "protocol/framing.hpp"

#include <algorithm>

#include "protocol/little_endian.hpp"

namespace armsight::wire {

std::string encode_frame(FrameType type, std::span<const char> payload) {
  std::string frame;
  frame.reserve(kFrameHeaderSize + payload.size());
  append_le<std::uint16_t>(frame, kFrameMagic);
  append_le<std::uint8_t>(frame, kProtocolMajor);
  append_le<std::uint8_t>(frame, static_cast<std::uint8_t>(type));
  append_le<std::uint32_t>(frame, static_cast<std::uint32_t>(payload.size()));
  frame.append(payload.data(), payload.size());
  return frame;
}

const char* to_text(FrameError error) {
  switch (error) {
    case FrameError::kNone: return "no error";
    case FrameError::kBadMagic: return "not an Armsight stream: the frame does not start with \"AS\"";
    case FrameError::kBadVersion: return "the peer speaks another major version of the protocol";
    case FrameError::kTooLong: return "the frame is longer than this stream allows";
    case FrameError::kWrongType: return "a frame of another kind of stream";
  }
  return "unknown framing error";
}

FrameDecoder::FrameDecoder(FrameType expected_type, std::size_t max_payload)
    : expected_type_(expected_type), max_payload_(max_payload) {}

FrameError FrameDecoder::check_header() {
  if (read_le<std::uint16_t>(header_.data()) != kFrameMagic) return FrameError::kBadMagic;
  peer_major_ = read_le<std::uint8_t>(header_.data() + 2);
  if (peer_major_ != kProtocolMajor) return FrameError::kBadVersion;
  if (read_le<std::uint8_t>(header_.data() + 3) != static_cast<std::uint8_t>(expected_type_))
    return FrameError::kWrongType;
  payload_size_ = read_le<std::uint32_t>(header_.data() + 4);
  return payload_size_ > max_payload_ ? FrameError::kTooLong : FrameError::kNone;
}

bool FrameDecoder::feed(std::span<const char> bytes, std::vector<std::string>& payloads) {
  while (error_ == FrameError::kNone) {
    if (header_filled_ < kFrameHeaderSize) {
      const std::size_t taken = std::min(kFrameHeaderSize - header_filled_, bytes.size());
      std::copy_n(bytes.begin(), taken, header_.begin() + static_cast<std::ptrdiff_t>(header_filled_));
      header_filled_ += taken;
      bytes = bytes.subspan(taken);
      if (header_filled_ < kFrameHeaderSize) return true;
      error_ = check_header();
      continue;
    }
    const std::size_t taken = std::min(payload_size_ - payload_.size(), bytes.size());
    payload_.append(bytes.data(), taken);
    bytes = bytes.subspan(taken);
    if (payload_.size() < payload_size_) return true;
    payloads.push_back(std::move(payload_));
    payload_.clear();
    header_filled_ = 0;
  }
  payload_.clear();
  return false;
}

}  // namespace armsight::wire
