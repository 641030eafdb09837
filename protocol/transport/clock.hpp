// The one seam through which a program learns the time and gives it away.
// Real pace: the machine's monotonic clock, a cycle begins when its time has come. Lockstep: arm_sim grants cycles; a
// message sent in cycle k acts in cycle k+1, and nobody's answer depends on how busy the machine is.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <string>

#include "shared/time.hpp"

namespace armsight::net {

enum class ChannelKind : std::uint8_t { kBus = 1, kLink = 2, kCamera = 3, kBus1 = 4, kBus2 = 5, kBus3 = 6 };
/// Of one of several buses, 0 … 3.
constexpr ChannelKind bus_channel(int bus) noexcept {
  return bus == 0 ? ChannelKind::kBus : static_cast<ChannelKind>(static_cast<int>(ChannelKind::kBus1) + bus - 1);
}

/// One direction-less channel of the account: what kind, and who is at its other end (sim participant id; 0 = arm_sim).
struct ChannelKey {
  ChannelKind kind = ChannelKind::kLink;
  std::uint32_t peer = 0;
  friend auto operator<=>(const ChannelKey&, const ChannelKey&) = default;
};

/// The peer that closes the program's time, e.g. arm_sim died: exit code 3.
class ClockLost : public std::exception {
 public:
  const char* what() const noexcept override { return "the simulated clock is gone"; }
};

/// Something with unsent bytes. Whoever waits in lockstep keeps all flows of its clock moving, or two programs that
/// wait for each other's bytes would wait for ever.
class Flow {
 public:
  virtual ~Flow() = default;
  virtual int flow_descriptor() const = 0;
  virtual bool has_unsent() const = 0;
  virtual void send_more() = 0;
};

class Clock {
 public:
  virtual ~Clock() = default;

  /// Own clock. In lockstep constant within a cycle.
  virtual Time now() const = 0;
  /// Ends this cycle and returns at the start of the next with its time. Real pace: sleeps to the next multiple of the
  /// period (a late caller skips the missed ones; how many is counted in missed()). Throws ClockLost.
  virtual Time wait_next_cycle() = 0;
  virtual bool is_lockstep() const = 0;
  virtual std::uint64_t missed() const = 0;
  /// How long after its time the cycle began that wait_next_cycle() last returned for. Lockstep: 0.
  virtual Duration lateness() const { return Duration{}; }

  // Lockstep account; without effect at real pace.
  virtual void count_sent(ChannelKey channel) = 0;
  virtual void count_received(ChannelKey channel) = 0;
  /// Arrival times (own clock) of the messages of this channel that act in this cycle. Real pace: empty.
  virtual std::span<const Time> due(ChannelKey channel) const = 0;
  /// Channels of a kind with messages due in this cycle: how a server learns of peers it has not met.
  virtual std::span<const ChannelKey> due_channels(ChannelKind kind) const = 0;
  /// Ids for the Hello messages; 0 without a simulated clock.
  virtual std::uint32_t participant() const = 0;
  virtual std::uint32_t arm_controller() const = 0;

  virtual void add_flow(Flow*) {}
  virtual void remove_flow(Flow*) {}
  virtual std::span<Flow* const> flows() const { return {}; }
};

/// The machine's own: CLOCK_MONOTONIC minus the time of the call, absolute clock_nanosleep.
std::unique_ptr<Clock> make_monotonic_clock(Duration period);
/// A participant of arm_sim's clock at an AF_UNIX path, in the pace arm_sim announces. Throws std::runtime_error with
/// the reason when nobody listens there. role: 1 arm controller, 2 host, 3 conductor (protocol/sim_clock.proto).
/// In lockstep it returns inside the first granted cycle, whose period is arm_sim's; an arm controller that wants
/// another is refused.
std::unique_ptr<Clock> join_sim_clock(const std::string& path, const std::string& name, int role, Duration period);

}  // namespace armsight::net
