// One SDO exchange at a time with one node, expedited or in segments: 100 ms time-out, two retries, then the node is
// named. A transfer that goes wrong half-way is aborted by us, with the code that says why, and begun again. Advanced
// once a cycle, never waits; no heap.
//
//   start ─► kPending: request ─► (segment ─►)* ─► kDone │ kAborted (code in value()) │ kTimedOut
#pragma once

#include <optional>
#include <span>

#include "protocol/sdo_segments.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

enum class SdoResult : std::uint8_t { kIdle, kPending, kDone, kAborted, kTimedOut };

class SdoClient {
 public:
  static constexpr Duration kTimeout = std::chrono::milliseconds(100);
  static constexpr int kAttempts = 3;
  static constexpr std::size_t kMaxBytes = 64;  ///< names of devices and versions; longer ones are refused

  void start_read(ObjectAddress object) noexcept { start(object, false, {}); }
  void start_write(ObjectAddress object, std::uint32_t value, std::uint8_t size) noexcept;
  /// Up to four bytes go expedited, more in segments; precondition: 1 … kMaxBytes.
  void start_write(ObjectAddress object, std::span<const std::uint8_t> bytes) noexcept { start(object, true, bytes); }

  /// Takes an answer of this node; others' objects are ignored.
  void receive(const CanFrame& frame, std::uint8_t node) noexcept;
  /// The request that has to go out now, if any.
  std::optional<CanFrame> request_to_send(std::uint8_t node, Time now) noexcept;

  SdoResult result() const noexcept { return result_; }
  std::uint32_t value() const noexcept;    ///< the first four bytes read; after kAborted: the abort code
  /// What was read.
  std::span<const std::uint8_t> bytes() const noexcept { return {bytes_.data(), count_}; }
  void clear() noexcept { result_ = SdoResult::kIdle; }

 private:
  enum class Step : std::uint8_t { kInitiate, kUpload, kDownload };

  void start(ObjectAddress object, bool is_write, std::span<const std::uint8_t> bytes) noexcept;
  void begin_attempt() noexcept;
  void answer_initiation(const CanFrame& frame, std::uint8_t node) noexcept;
  void answer_segment(const CanFrame& frame, std::uint8_t node) noexcept;
  void take_segment(const SdoSegment& segment) noexcept;
  void go_on(Step step) noexcept;
  void fail(std::uint32_t code) noexcept;
  CanFrame next_request(std::uint8_t node) const noexcept;
  SdoSegment next_segment() const noexcept;

  ObjectAddress object_;
  bool is_write_ = false, is_sent_ = false, toggle_ = false;
  Step step_ = Step::kInitiate;
  std::array<std::uint8_t, kMaxBytes> bytes_{};
  std::size_t count_ = 0, done_ = 0;      ///< bytes in all (write) or so far (read); bytes confirmed
  std::uint32_t announced_ = 0;           ///< total of a segmented read, 0: not told
  std::optional<std::uint32_t> abort_to_send_;
  std::uint32_t abort_code_ = 0;
  int attempts_ = 0;
  Time sent_{};
  SdoResult result_ = SdoResult::kIdle;
};

}  // namespace armsight::arm
