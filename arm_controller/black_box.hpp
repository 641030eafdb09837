// The last kKeptTicks cycles and what is needed to go through them again: a checkpoint of the whole state before them,
// then every input (frames, messages, times, what the bus refused) and every output. Kept by the file thread, written
// out when a fault latches. Bounded: about two kilobytes a cycle, three thousand cycles at most.
#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "arm_controller/tick_tape.hpp"
#include "protocol/recording.pb.h"

namespace armsight::arm {

class BlackBox {
 public:
  void keep(const TickRecord& record);
  void keep(const OrdersRecord& orders);
  void keep_checkpoint(std::uint64_t cycle, std::span<const std::byte> state);
  /// Throws std::runtime_error where the file cannot be written; never leaves half a file under its name.
  void write(const std::filesystem::path& file, const wire::RecordingInfo& info) const;
  std::size_t size() const { return cycles_.size(); }

 private:
  struct Cycle {
    CycleRecord record;
    std::vector<TapeFrame> frames;
    std::unique_ptr<const TickInbox> orders;  ///< few cycles have any, and they are large
  };
  struct Checkpoint {
    std::uint64_t cycle;
    std::vector<std::byte> state;
  };
  void forget_old();
  std::deque<Cycle> cycles_;
  std::deque<OrdersRecord> orders_;  ///< come beside their cycle, from another ring
  std::deque<Checkpoint> checkpoints_;
};

}  // namespace armsight::arm
