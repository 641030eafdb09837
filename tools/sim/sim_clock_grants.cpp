// What a cycle hands on: each participant is granted it with the messages that are due, and what it sent meanwhile
// becomes due in the next one.
#include "tools/sim/sim_clock_server_impl.hpp"

namespace armsight::sim {

void SimClockServer::Impl::grant_all() {
  for (Participant& p : participants) {
    if (p.id == 0) continue;
    grant(p);
    p.phase = ParticipantPhase::kWorking;
  }
  next_arrivals.clear();
}

void SimClockServer::Impl::grant(Participant& to) {
  wire::SimClockMessage message;
  wire::Grant& grant = *message.mutable_grant();
  grant.set_cycle(cycle);
  grant.set_time_ns(to.crystal.to_own_ns(to_ns(clock.now())));
  grant.set_arm_controller(controller());
  grant.set_participants(static_cast<std::uint32_t>(joined()));
  for (const auto& [channel, times] : next_arrivals[to.id]) {
    wire::Arrivals& arrivals = *grant.add_arrivals();
    arrivals.set_kind(static_cast<wire::ChannelKind>(channel.kind));
    arrivals.set_peer(channel.peer);
    for (const Time time : times) arrivals.add_time_ns(to.crystal.to_own_ns(to_ns(time)));
  }
  to.stream->send(message.SerializeAsString());
}

/// What was sent in this cycle becomes due: to arm_sim at once, to participants in their next cycle.
void SimClockServer::Impl::hand_on() {
  clock.account().begin_cycle();
  for (Participant& p : participants) hand_on_from(p);
  clock.account().finish_grant();
  std::erase_if(participants, [](const Participant& p) { return p.phase == ParticipantPhase::kLeaving; });
}

void SimClockServer::Impl::hand_on_from(Participant& sender) {
  for (const auto& [channel, total] : sender.sent) {
    std::uint64_t& handed_on = sender.handed_on[channel];
    if (total <= handed_on) continue;
    const std::size_t count = static_cast<std::size_t>(total - handed_on);
    if (channel.peer == 0) {
      for (std::size_t i = 0; i < count; ++i) clock.account().add_due({channel.kind, sender.id}, clock.now());
    } else {
      next_arrivals[channel.peer][{channel.kind, sender.id}] =
          link_arrivals(options.seed, sender.id, channel.peer, handed_on, count, clock.now(), options.period);
    }
    handed_on = total;
  }
}

void SimClockServer::end_cycle() {
  ++impl_->cycle;
  const auto cycles = static_cast<std::int64_t>(impl_->cycle);
  impl_->clock.set_now(time_from_ns(kFirstTime_ns) + cycles * impl_->options.period);
  for (const auto& [channel, times] : impl_->clock.take_arrivals()) {
    std::vector<Time>& due = impl_->next_arrivals[channel.peer][{channel.kind, 0}];
    due.insert(due.end(), times.begin(), times.end());
  }
}

}  // namespace armsight::sim
