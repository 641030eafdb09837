// The object dictionary of a simulated CANopen node: values up to four bytes and texts, with their access and ranges.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "protocol/can_frames.hpp"

namespace armsight::sim {

/// CiA 301 abort codes that the simulated nodes give; 0: no error.
inline constexpr std::uint32_t kBadCommand = 0x05040001, kUnsupportedAccess = 0x06010000, kWriteToReadOnly = 0x06010002,
                               kNoSuchObject = 0x06020000, kCannotMap = 0x06040041, kMappingTooLong = 0x06040042,
                               kTooLong = 0x06070012, kTooShort = 0x06070013, kNoSuchSub = 0x06090011,
                               kBadValue = 0x06090030, kBadState = 0x08000022;

enum class Access : std::uint8_t { kReadOnly, kReadWrite };

struct Object {
  std::uint8_t size = 4;
  Access access = Access::kReadOnly;
  std::uint32_t value = 0;
};

/// A visible string: what SDO moves in segments.
struct TextObject {
  std::size_t max_bytes = 0;  ///< 0: read only
  std::string text;
};

class ObjectDictionary {
 public:
  void add_text(std::uint16_t index, std::size_t max_bytes, const std::string& text) {
    texts_[key({index, 0})] = {max_bytes, text};
  }
  TextObject* find_text(ObjectAddress address) {
    const auto found = texts_.find(key(address));
    return found == texts_.end() ? nullptr : &found->second;
  }
  void add(std::uint16_t index, std::uint8_t sub, std::uint8_t size, Access access, std::uint32_t value) {
    objects_[key({index, sub})] = {size, access, value};
  }
  const Object* find(ObjectAddress address) const {
    const auto found = objects_.find(key(address));
    return found == objects_.end() ? nullptr : &found->second;
  }
  /// Of an object that exists.
  std::uint32_t get(std::uint16_t index, std::uint8_t sub = 0) const { return objects_.at(key({index, sub})).value; }
  void set(ObjectAddress address, std::uint32_t value) { objects_.at(key(address)).value = value; }
  /// Why there is nothing at this address.
  std::uint32_t missing(ObjectAddress address) const {
    const auto next = objects_.lower_bound(key({address.index, 0}));
    return next != objects_.end() && next->first >> 8 == address.index ? kNoSuchSub : kNoSuchObject;
  }
  /// What forbids a write of so many bytes, before the value itself is judged.
  std::uint32_t forbids_write(ObjectAddress address, std::uint8_t size) const {
    const Object* object = find(address);
    if (object == nullptr) return missing(address);
    if (object->access == Access::kReadOnly) return kWriteToReadOnly;
    if (size > object->size) return kTooLong;
    return size < object->size ? kTooShort : 0;
  }

 private:
  static constexpr std::uint32_t key(ObjectAddress a) { return (std::uint32_t{a.index} << 8) | a.sub; }
  std::map<std::uint32_t, Object> objects_;
  std::map<std::uint32_t, TextObject> texts_;
};

}  // namespace armsight::sim
