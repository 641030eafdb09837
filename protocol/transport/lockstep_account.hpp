// Who sent how much to whom, and what acts in this cycle: the bookkeeping behind "a message sent in cycle k acts in
// cycle k+1". Used by the participants' clock and by arm_sim's own. No I/O.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "protocol/transport/clock.hpp"

namespace armsight::net {

class LockstepAccount {
 public:
  void count_sent(ChannelKey channel) { ++sent_[channel]; }
  /// Takes the first due message of the channel off the list.
  void count_received(ChannelKey channel);

  /// A new cycle begins: what was due and never taken stays due, before the new arrivals.
  void begin_cycle();
  void add_due(ChannelKey channel, Time arrival);
  /// Afterwards due_channels() is up to date.
  void finish_grant();

  std::span<const Time> due(ChannelKey channel) const;
  std::span<const ChannelKey> due_channels(ChannelKind kind) const;
  const std::map<ChannelKey, std::uint64_t>& sent() const { return sent_; }
  const std::map<ChannelKey, std::uint64_t>& received() const { return received_; }

 private:
  struct DueList {
    std::vector<Time> times;
    std::size_t taken = 0;
  };
  std::map<ChannelKey, std::uint64_t> sent_, received_;
  std::map<ChannelKey, DueList> due_;
  std::map<ChannelKind, std::vector<ChannelKey>> due_channels_;
};

}  // namespace armsight::net
