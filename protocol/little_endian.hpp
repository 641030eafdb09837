// Integers ↔ little-endian bytes, the order of every wire and file of ours, whatever the machine.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

namespace armsight {

/// Reads an integer from sizeof(T) bytes.
template <std::integral T, typename Byte>
constexpr T read_le(const Byte* bytes) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(bytes[i])) << (8 * i);
  return static_cast<T>(value);
}

/// Writes an integer to sizeof(T) bytes.
template <std::integral T, typename Byte>
constexpr void write_le(Byte* bytes, T value) noexcept {
  const auto bits = static_cast<std::uint64_t>(static_cast<std::make_unsigned_t<T>>(value));
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = static_cast<Byte>((bits >> (8 * i)) & 0xFF);
}

template <std::integral T>
void append_le(std::string& bytes, std::type_identity_t<T> value) {
  char raw[sizeof(T)];
  write_le<T>(raw, value);
  bytes.append(raw, sizeof(T));
}

}  // namespace armsight
