#include "protocol/transport/lockstep_account.hpp"

namespace armsight::net {

void LockstepAccount::count_received(ChannelKey channel) {
  ++received_[channel];
  const auto found = due_.find(channel);
  if (found != due_.end() && found->second.taken < found->second.times.size()) ++found->second.taken;
}

void LockstepAccount::begin_cycle() {
  for (auto it = due_.begin(); it != due_.end();) {
    DueList& list = it->second;
    list.times.erase(list.times.begin(), list.times.begin() + static_cast<std::ptrdiff_t>(list.taken));
    list.taken = 0;
    it = list.times.empty() ? due_.erase(it) : std::next(it);
  }
}

void LockstepAccount::add_due(ChannelKey channel, Time arrival) { due_[channel].times.push_back(arrival); }

void LockstepAccount::finish_grant() {
  for (auto& [kind, channels] : due_channels_) channels.clear();
  for (const auto& [channel, list] : due_) due_channels_[channel.kind].push_back(channel);
}

std::span<const Time> LockstepAccount::due(ChannelKey channel) const {
  const auto found = due_.find(channel);
  if (found == due_.end()) return {};
  return std::span<const Time>(found->second.times).subspan(found->second.taken);
}

std::span<const ChannelKey> LockstepAccount::due_channels(ChannelKind kind) const {
  const auto found = due_channels_.find(kind);
  if (found == due_channels_.end()) return {};
  return found->second;
}

}  // namespace armsight::net
