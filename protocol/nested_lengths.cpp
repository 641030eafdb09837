#include "protocol/nested_lengths.hpp"

#include <cstdint>
#include <optional>

namespace armsight::wire {
namespace {

enum WireType : std::uint64_t { kVarint = 0, kFixed64 = 1, kDelimited = 2, kFixed32 = 5 };

std::optional<std::uint64_t> take_varint(std::string_view& bytes) noexcept {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !bytes.empty(); shift += 7) {
    const auto byte = static_cast<unsigned char>(bytes.front());
    bytes.remove_prefix(1);
    value |= std::uint64_t{byte & 0x7Fu} << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

bool fit(std::string_view bytes, int nested_levels) noexcept {
  while (!bytes.empty()) {
    const auto tag = take_varint(bytes);
    if (!tag) return false;
    std::uint64_t size = 0;
    switch (*tag & 7) {
      case kVarint:
        if (!take_varint(bytes)) return false;
        break;
      case kFixed64: size = 8; break;
      case kFixed32: size = 4; break;
      case kDelimited: {
        const auto announced = take_varint(bytes);
        if (!announced) return false;
        size = *announced;
        break;
      }
      default: return false;
    }
    if (size > bytes.size()) return false;
    const bool is_nested = (*tag & 7) == kDelimited && nested_levels > 0;
    if (is_nested && !fit(bytes.substr(0, size), nested_levels - 1)) return false;
    bytes.remove_prefix(size);
  }
  return true;
}

}  // namespace

bool lengths_fit(std::string_view payload) noexcept { return fit(payload, 1); }

}  // namespace armsight::wire
