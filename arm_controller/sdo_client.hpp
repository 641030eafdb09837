// One expedited SDO exchange at a time with one node: 100 ms time-out, two retries, then the node is named. Advanced
// once a cycle, never waits; no heap.
#pragma once

#include <optional>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

enum class SdoResult : std::uint8_t { kIdle, kPending, kDone, kAborted, kTimedOut };

class SdoClient {
 public:
  static constexpr Duration kTimeout = std::chrono::milliseconds(100);
  static constexpr int kAttempts = 3;

  void start_read(ObjectAddress object) noexcept { start({object, 0, 0}, false); }
  void start_write(ObjectAddress object, std::uint32_t value, std::uint8_t size) noexcept {
    start({object, value, size}, true);
  }

  /// Takes an answer of this node; others' objects are ignored.
  void receive(const CanFrame& frame, std::uint8_t node) noexcept;
  /// The request that has to go out now, if any.
  std::optional<CanFrame> request_to_send(std::uint8_t node, Time now) noexcept;

  SdoResult result() const noexcept { return result_; }
  std::uint32_t value() const noexcept { return value_; }  ///< read, or the abort code
  void clear() noexcept { result_ = SdoResult::kIdle; }

 private:
  void start(const SdoWrite& request, bool is_write) noexcept;

  SdoWrite request_{};
  bool is_write_ = false, is_sent_ = false;
  int attempts_ = 0;
  Time sent_{};
  SdoResult result_ = SdoResult::kIdle;
  std::uint32_t value_ = 0;
};

}  // namespace armsight::arm
