// What a cycle leaves behind for the file thread, without waiting: state, events, raw frames and messages through rings,
// and now and then a checkpoint. The file thread keeps the last kKeptTicks and what leads to them, and writes them out
// when a fault latches (file_writer).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

#include "arm_controller/can_bus.hpp"
#include "arm_controller/messages.hpp"

namespace armsight::arm {

inline constexpr std::size_t kKeptTicks = 2000;          ///< 8 s at 250 Hz, 4 s at 500 Hz
inline constexpr std::uint64_t kCheckpointEvery = 1000;  ///< cycles

struct TapeFrame {
  BusFrame frame;
  bool is_sent = false;
  SendResult result = SendResult::kSent;  ///< of one that was sent; what found no room is here too
};

/// One cycle, without its frames.
struct CycleRecord {
  ArmSnapshot state;
  Time cycle_time;
  std::uint64_t cycle = 0;
  std::uint64_t missed = 0;
  double tick_us = 0.0;
  BusErrors errors;                              ///< that this cycle was told of
  bool stop = false, model_not_saved = false, has_orders = false;
  std::optional<Lease> lease;
  std::size_t frame_count = 0;
  std::size_t frames_left_out = 0;
};

struct TickRecord : CycleRecord {
  static constexpr std::size_t kMaxFrames = 72;  ///< SYNC, set-points and samples of 9 nodes, their SDO, all echoes
  std::array<TapeFrame, kMaxFrames> frames;
};

/// Messages that a cycle was given, where there were any.
struct OrdersRecord {
  std::uint64_t cycle = 0;
  TickInbox inbox;
};

/// Two places for the bytes of a LoopState: the cycle fills one while the file thread reads the other.
class Checkpoints {
 public:
  void reserve(std::size_t bytes) {
    for (Place& place : places_) place.bytes.resize(bytes);
  }
  /// The state before cycle + 1; false: both places are still being read.
  bool put(std::uint64_t cycle, std::span<const std::byte> bytes) noexcept {
    for (Place& place : places_) {
      if (place.is_full.load(std::memory_order_acquire)) continue;
      std::memcpy(place.bytes.data(), bytes.data(), bytes.size());
      place.cycle = cycle;
      place.is_full.store(true, std::memory_order_release);
      return true;
    }
    return false;
  }
  template <typename OnCheckpoint>
  void take(OnCheckpoint&& on_checkpoint) {
    for (Place& place : places_) {
      if (!place.is_full.load(std::memory_order_acquire)) continue;
      on_checkpoint(place.cycle, std::span<const std::byte>(place.bytes));
      place.is_full.store(false, std::memory_order_release);
    }
  }

 private:
  struct Place {
    std::vector<std::byte> bytes;
    std::uint64_t cycle = 0;
    std::atomic<bool> is_full{false};
  };
  std::array<Place, 2> places_;
};

/// From the cycle to the file thread.
struct Tape {
  Ring<TickRecord, 128> ticks;
  Ring<OrdersRecord, 16> orders;
  Ring<Event, 128> events;
  Checkpoints checkpoints;
};

}  // namespace armsight::arm
