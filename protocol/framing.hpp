// Byte stream ↔ frames: u16 magic 0x5341 ("AS"), u8 major, u8 type, u32 payload length, payload; little-endian.
// The length is checked before anything is stored, so a peer cannot make us allocate (controller.md §8.3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace armsight::wire {

inline constexpr std::uint16_t kFrameMagic = 0x5341;
inline constexpr std::uint8_t kProtocolMajor = 1;
inline constexpr std::uint32_t kProtocolVersion = 100;  ///< major * 100 + minor
inline constexpr std::size_t kFrameHeaderSize = 8;

enum class FrameType : std::uint8_t { kLink = 1, kCamera = 2, kSimClock = 3 };

inline constexpr std::size_t kMaxToController = 4096;
inline constexpr std::size_t kMaxFromController = 64 * 1024;
inline constexpr std::size_t kMaxCameraFrame = 16 * 1024 * 1024;
inline constexpr std::size_t kMaxSimClock = 64 * 1024;

/// Header and payload as one buffer.
std::string encode_frame(FrameType type, std::span<const char> payload);

enum class FrameError { kNone, kBadMagic, kBadVersion, kTooLong, kWrongType };
const char* to_text(FrameError error);

/// Cuts a byte stream into payloads. After an error it stays in error: the stream is lost.
class FrameDecoder {
 public:
  FrameDecoder(FrameType expected_type, std::size_t max_payload);

  /// Takes bytes; complete payloads are appended to `payloads`. Returns false once the stream is in error.
  bool feed(std::span<const char> bytes, std::vector<std::string>& payloads);
  FrameError error() const { return error_; }
  int peer_major() const { return peer_major_; }  ///< of the last header seen

 private:
  FrameError check_header();

  FrameType expected_type_;
  std::size_t max_payload_;
  std::array<char, kFrameHeaderSize> header_{};
  std::size_t header_filled_ = 0;
  std::size_t payload_size_ = 0;  ///< as the complete header says
  std::string payload_;
  FrameError error_ = FrameError::kNone;
  int peer_major_ = kProtocolMajor;
};

}  // namespace armsight::wire
