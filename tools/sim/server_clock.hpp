// arm_sim's own view of the time it gives to others: simulated time, and in lockstep its side of the account.
#pragma once

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "protocol/transport/lockstep_account.hpp"
#include "protocol/transport/wait.hpp"

namespace armsight::sim {

class ServerClock : public net::Clock {
 public:
  explicit ServerClock(bool is_lockstep) : is_lockstep_(is_lockstep) {}

  /// Lockstep: simulated time. Real pace: the machine's monotonic clock. Safe to call from the camera's thread.
  Time now() const override { return is_lockstep_ ? now_ : time_from_ns(net::monotonic_ns()); }
  void set_now(Time now) { now_ = now; }

  Time wait_next_cycle() override { return now(); }
  bool is_lockstep() const override { return is_lockstep_; }
  std::uint64_t missed() const override { return 0; }

  void count_sent(net::ChannelKey channel) override { count_sent_at(channel, now_); }
  /// A message to a participant that arrives there at a simulated time.
  void count_sent_at(net::ChannelKey channel, Time arrival) {
    if (is_lockstep_) arrivals_[channel].push_back(arrival);
  }
  void count_received(net::ChannelKey channel) override {
    if (is_lockstep_) account_.count_received(channel);
  }
  std::span<const Time> due(net::ChannelKey channel) const override { return account_.due(channel); }
  std::span<const net::ChannelKey> due_channels(net::ChannelKind kind) const override {
    return account_.due_channels(kind);
  }
  std::uint32_t participant() const override { return 0; }
  std::uint32_t arm_controller() const override { return 0; }
  void add_flow(net::Flow* flow) override {
    if (is_lockstep_) flows_.push_back(flow);
  }
  void remove_flow(net::Flow* flow) override {
    if (is_lockstep_) std::erase(flows_, flow);
  }
  std::span<net::Flow* const> flows() const override { return flows_; }

  net::LockstepAccount& account() { return account_; }
  /// What was sent to participants since the last call, per channel.
  std::map<net::ChannelKey, std::vector<Time>> take_arrivals() { return std::exchange(arrivals_, {}); }

 private:
  bool is_lockstep_;
  Time now_;
  net::LockstepAccount account_;
  std::map<net::ChannelKey, std::vector<Time>> arrivals_;
  std::vector<net::Flow*> flows_;
};

}  // namespace armsight::sim
