// SDO transfers of more than four bytes (CiA 301): an initiation that tells the size, then segments of up to seven
// bytes with a toggle bit. Expedited transfers are in can_frames.hpp.
#pragma once

#include <span>

#include "protocol/can_frames.hpp"

namespace armsight {

/// Initiation of a segmented download (0x21, to the server) or upload (0x41, from it).
struct SdoSegmentedStart { ObjectAddress object; std::uint32_t total_bytes; };
/// Up to seven bytes; in a download from the client (0x00 …), in an upload from the server: the same bits.
struct SdoSegment {
  bool toggle = false;
  bool is_last = false;
  std::uint8_t size = 0;
  std::array<std::uint8_t, 7> data{};
};
/// What the other side says to that: 0x60/0x70 asks for the next segment of an upload, 0x20/0x30 confirms one of a download.
struct SdoSegmentRequest { bool toggle; };
struct SdoSegmentConfirmation { bool toggle; };

inline constexpr std::uint32_t kSdoToggleError = 0x05030000, kSdoTimeout = 0x05040000, kSdoBadCommand = 0x05040001,
                               kSdoOutOfMemory = 0x05040005, kSdoWrongLength = 0x06070010;

CanFrame encode_request(const SdoSegmentedStart& m, std::uint8_t node) noexcept;
CanFrame encode_answer(const SdoSegmentedStart& m, std::uint8_t node) noexcept;
CanFrame encode_request(const SdoSegment& m, std::uint8_t node) noexcept;
CanFrame encode_answer(const SdoSegment& m, std::uint8_t node) noexcept;
CanFrame encode(const SdoSegmentRequest& m, std::uint8_t node) noexcept;
CanFrame encode(const SdoSegmentConfirmation& m, std::uint8_t node) noexcept;

std::optional<SdoSegmentedStart> decode_sdo_segmented_write(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoSegmentedStart> decode_sdo_segmented_answer(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoSegment> decode_sdo_request_segment(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoSegment> decode_sdo_answer_segment(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoSegmentRequest> decode_sdo_segment_request(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoSegmentConfirmation> decode_sdo_segment_confirmation(const CanFrame& f, std::uint8_t node) noexcept;
/// An abort that the client sent; the server forgets its transfer.
std::optional<SdoAbort> decode_sdo_request_abort(const CanFrame& f, std::uint8_t node) noexcept;

}  // namespace armsight
