// One CAN frame on the emulated bus' socket (AF_UNIX, SOCK_SEQPACKET): i64 time_ns, u32 id, u8 size, u8 flags, u16 0,
// 8 data bytes, little-endian. An error frame's first data byte is the state that its receiver is in now: 0 error active,
// 1 error passive, 2 bus-off. A joiner's first packet: "ASCB", u32 simulated participant, 16 zero bytes.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "protocol/can_frames.hpp"
#include "protocol/little_endian.hpp"

namespace armsight::arm {

inline constexpr std::size_t kBusPacketSize = 24;
using BusPacketBytes = std::array<char, kBusPacketSize>;

inline constexpr std::uint8_t kFlagOwnEcho = 1, kFlagErrorFrame = 2, kFlagDropped = 4, kFlagFd = 8;
inline constexpr std::uint8_t kErrorPassiveState = 1, kBusOffState = 2;
inline constexpr char kBusMagic[4] = {'A', 'S', 'C', 'B'};

struct BusPacket {
  std::int64_t time_ns = 0;
  CanFrame frame;
  std::uint8_t flags = 0;
};

inline BusPacketBytes encode_bus_packet(const BusPacket& packet) noexcept {
  BusPacketBytes bytes{};
  write_le<std::int64_t>(bytes.data(), packet.time_ns);
  write_le<std::uint32_t>(bytes.data() + 8, packet.frame.id);
  bytes[12] = static_cast<char>(packet.frame.size);
  bytes[13] = static_cast<char>(packet.flags | (packet.frame.is_fd ? kFlagFd : 0));
  std::memcpy(bytes.data() + 16, packet.frame.data.data(), 8);
  return bytes;
}

inline std::optional<BusPacket> decode_bus_packet(std::span<const char> bytes) noexcept {
  if (bytes.size() != kBusPacketSize) return std::nullopt;
  BusPacket packet;
  packet.time_ns = read_le<std::int64_t>(bytes.data());
  packet.frame.id = read_le<std::uint32_t>(bytes.data() + 8);
  packet.frame.size = static_cast<std::uint8_t>(bytes[12]);
  packet.frame.is_fd = (bytes[13] & kFlagFd) != 0;
  packet.flags = static_cast<std::uint8_t>(bytes[13] & ~kFlagFd);
  std::memcpy(packet.frame.data.data(), bytes.data() + 16, 8);
  if (packet.frame.size > 8 || packet.frame.id > 0x7FF) return std::nullopt;
  return packet;
}

inline BusPacketBytes encode_bus_join(std::uint32_t participant) noexcept {
  BusPacketBytes bytes{};
  std::memcpy(bytes.data(), kBusMagic, 4);
  write_le<std::uint32_t>(bytes.data() + 4, participant);
  return bytes;
}

/// The participant of a joiner's first packet.
inline std::optional<std::uint32_t> decode_bus_join(std::span<const char> bytes) noexcept {
  if (bytes.size() != kBusPacketSize || std::memcmp(bytes.data(), kBusMagic, 4) != 0) return std::nullopt;
  return read_le<std::uint32_t>(bytes.data() + 4);
}

}  // namespace armsight::arm
