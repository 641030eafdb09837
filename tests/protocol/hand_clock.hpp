// A clock that a test sets.
#pragma once

#include "protocol/transport/clock.hpp"

namespace armsight::arm::test {

class HandClock : public net::Clock {
 public:
  Time time = time_from_ns(1'000'000'000);
  Time now() const override { return time; }
  Time wait_next_cycle() override { return time; }
  bool is_lockstep() const override { return false; }
  std::uint64_t missed() const override { return 0; }
  void count_sent(net::ChannelKey) override {}
  void count_received(net::ChannelKey) override {}
  std::span<const Time> due(net::ChannelKey) const override { return {}; }
  std::span<const net::ChannelKey> due_channels(net::ChannelKind) const override { return {}; }
  std::uint32_t participant() const override { return 0; }
  std::uint32_t arm_controller() const override { return 0; }
};

}  // namespace armsight::arm::test
