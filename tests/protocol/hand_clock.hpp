// A clock that a test sets.
#pragma once

#include "protocol/transport/clock.hpp"

namespace armsight::net::test {

class HandClock : public Clock {
 public:
  Time time = time_from_ns(1'000'000'000);
  Duration period{0};  ///< that it goes on by itself from cycle to cycle
  Time now() const override { return time; }
  Time wait_next_cycle() override { return time += period; }
  bool is_lockstep() const override { return false; }
  std::uint64_t missed() const override { return 0; }
  void count_sent(ChannelKey) override {}
  void count_received(ChannelKey) override {}
  std::span<const Time> due(ChannelKey) const override { return {}; }
  std::span<const ChannelKey> due_channels(ChannelKind) const override { return {}; }
  std::uint32_t participant() const override { return 0; }
  std::uint32_t arm_controller() const override { return 0; }
};

}  // namespace armsight::net::test
