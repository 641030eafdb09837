// What a cycle leaves behind for the file thread: state, events and raw frames through one ring, without waiting. The
// file thread keeps the last kKeptTicks and writes them out when a fault latches (file_writer).
#pragma once

#include <array>
#include <cstddef>

#include "arm_controller/can_bus.hpp"
#include "arm_controller/messages.hpp"

namespace armsight::arm {

inline constexpr std::size_t kKeptTicks = 2000;  ///< 8 s at 250 Hz

struct TapeFrame { BusFrame frame; bool is_sent = false; };

struct TickRecord {
  static constexpr std::size_t kMaxFrames = 40;  ///< SYNC, 9 set-points and samples, SDO of 9 nodes, heartbeats
  ArmSnapshot state;
  Time cycle_time;
  std::uint64_t cycle = 0;
  std::uint64_t missed = 0;
  double tick_us = 0.0;
  std::array<TapeFrame, kMaxFrames> frames;
  std::size_t frame_count = 0;
  std::size_t frames_left_out = 0;
};

/// From the cycle to the file thread.
struct Tape {
  Ring<TickRecord, 128> ticks;
  Ring<Event, 128> events;
};

}  // namespace armsight::arm
