// What a bus really carried: frames with the times of their ends in, load and latest responses out. Beside bus_budget,
// which says what it may carry.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight {

/// Bits of this very classic frame on the wire, from start of frame to the end of the space after it, its stuffing
/// counted.
int stuffed_bits(const CanFrame& frame) noexcept;

struct SeenMessage {
  std::uint64_t count = 0;
  std::int64_t bits = 0;            ///< of all, as they were, stuffing counted; CAN FD frames at their longest
  int most_bits = 0;
  double wire_s = 0.0;              ///< of all, the same in time
  double worst_case_s = 0.0;        ///< of all, had each been stuffed as often as its size allows
  std::optional<double> latest_s;    ///< its end after the last SYNC began; nullopt: there was no SYNC before
};

class BusTraffic {
 public:
  explicit BusTraffic(const BusRates& rates) : rates_(rates) {}

  /// In order of time.
  void add(const CanFrame& frame, Time end);

  const std::map<std::uint32_t, SeenMessage>& messages() const { return messages_; }
  /// From the first frame's end to the last one's.
  double duration_s() const;
  double load() const;             ///< frames as they were
  double worst_case_load() const;  ///< the same frames, each at its longest
  /// Of the fullest tenth of a second, frames as they were.
  double highest_load() const { return highest_load_; }

 private:
  BusRates rates_;
  std::map<std::uint32_t, SeenMessage> messages_;
  std::optional<Time> first_, last_, sync_begin_;
  std::int64_t window_ = 0;
  double window_s_ = 0.0;
  double highest_load_ = 0.0;
};

}  // namespace armsight
