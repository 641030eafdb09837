// The machine's monotonic clock as one of our Clocks. now() may be called from any thread.
#pragma once

#include <atomic>

#include "protocol/transport/clock.hpp"

namespace armsight::net {

/// A participant's own clock against time itself: own = t·(1 + skew) + offset.
struct Crystal {
  std::int64_t offset_ns = 0;
  std::int32_t skew_ppb = 0;

  std::int64_t to_own_ns(std::int64_t monotonic) const;
  std::int64_t to_monotonic_ns(std::int64_t own) const;

 private:
  static std::int64_t scaled(std::int64_t ns, std::int32_t ppb);
};

class MonotonicClock : public Clock {
 public:
  MonotonicClock(Crystal crystal, Duration period);

  Time now() const override;
  Time wait_next_cycle() override;
  bool is_lockstep() const override { return false; }
  std::uint64_t missed() const override { return missed_.load(std::memory_order_relaxed); }
  Duration lateness() const override { return lateness_; }
  void count_sent(ChannelKey) override {}
  void count_received(ChannelKey) override {}
  std::span<const Time> due(ChannelKey) const override { return {}; }
  std::span<const ChannelKey> due_channels(ChannelKind) const override { return {}; }
  std::uint32_t participant() const override { return 0; }
  std::uint32_t arm_controller() const override { return 0; }

 private:
  Crystal crystal_;
  std::int64_t period_ns_;
  std::int64_t next_ns_;
  Duration lateness_{};  ///< of the thread that waits
  std::atomic<std::uint64_t> missed_{0};
};

}  // namespace armsight::net
