#include <algorithm>
#include <cstdio>

#include "tools/sim/sim_clock_server_impl.hpp"

namespace armsight::sim {

namespace {

const net::StreamOptions kStreamOptions{wire::FrameType::kSimClock, wire::kMaxSimClock, wire::kMaxSimClock,
                                        1024 * 1024};

}  // namespace

std::uint32_t SimClockServer::Impl::controller() const {
  std::uint32_t id = 0;
  for (const Participant& p : participants)
    if (p.role == wire::SIM_ROLE_ARM_CONTROLLER) id = p.id;
  return id;
}

std::size_t SimClockServer::Impl::joined() const {
  return static_cast<std::size_t>(
      std::count_if(participants.begin(), participants.end(), [](const Participant& p) { return p.id != 0; }));
}

bool SimClockServer::Impl::all_are(std::initializer_list<ParticipantPhase> phases) const {
  return std::all_of(participants.begin(), participants.end(), [phases](const Participant& p) {
    return p.id == 0 || std::find(phases.begin(), phases.end(), p.phase) != phases.end();
  });
}

std::vector<int> SimClockServer::Impl::descriptors() const {
  std::vector<int> all{listener->descriptor()};
  for (const Participant& p : participants) all.push_back(p.stream->descriptor());
  return all;
}

void SimClockServer::Impl::serve() {
  while (auto stream = listener->accept(kStreamOptions, stream_clock)) {
    Participant joiner;
    joiner.stream = std::move(stream);
    participants.push_back(std::move(joiner));
  }
  for (Participant& p : participants)
    for (const net::Received& message : p.stream->receive()) handle(p, message.payload);
  drop_closed();
}

void SimClockServer::Impl::handle(Participant& from, const std::string& payload) {
  wire::SimClockMessage message;
  if (!message.ParseFromString(payload)) return from.stream->close("undecodable message");
  if (message.has_join() && from.id == 0) return welcome(from, message.join());
  if (from.id == 0) return from.stream->close("spoke before joining");
  if (message.has_done()) return take_totals(from, message.done());
  if (message.has_leave()) {
    if (message.leave().has_last()) take_totals(from, message.leave().last());
    from.phase = ParticipantPhase::kLeaving;
    return;
  }
  const bool may_wish = from.role == wire::SIM_ROLE_CONDUCTOR;
  const std::string refusal = "only a conductor may ask for that";
  if (message.has_inject_drift()) return answer(from, may_wish ? wishes.inject_drift() : refusal);
  if (message.has_finish()) {
    const std::string error = may_wish ? wishes.finish(message.finish().truth_file()) : refusal;
    is_finished = is_finished || error.empty();
    return answer(from, error);
  }
  from.stream->close("unknown message");
}

void SimClockServer::Impl::welcome(Participant& joiner, const wire::Join& join) {
  joiner.id = ++last_id;
  joiner.role = join.role();
  if (joiner.role == wire::SIM_ROLE_ARM_CONTROLLER) last_controller = joiner.id;
  joiner.name = join.name();
  joiner.crystal = make_crystal(options.seed, joiner.id, join.role() == wire::SIM_ROLE_CONDUCTOR);
  {
    const std::lock_guard lock(crystals_mutex);
    crystals[joiner.id] = joiner.crystal;
  }
  wire::SimClockMessage message;
  wire::Welcome& welcome = *message.mutable_welcome();
  welcome.set_participant(joiner.id);
  welcome.set_arm_controller(controller());
  welcome.set_pace(options.is_lockstep ? wire::SIM_PACE_LOCKSTEP : wire::SIM_PACE_REAL);
  welcome.set_period_ns(options.period.count());
  welcome.set_clock_offset_ns(joiner.crystal.offset_ns);
  welcome.set_clock_skew_ppb(joiner.crystal.skew_ppb);
  joiner.stream->send(message.SerializeAsString());
}

void SimClockServer::Impl::take_totals(Participant& from, const wire::Done& done) {
  if (from.phase != ParticipantPhase::kWorking || done.cycle() != cycle)
    return from.stream->close("Done of another cycle");
  for (const wire::ChannelCount& count : done.sent())
    from.sent[{static_cast<ChannelKind>(count.kind()), count.peer()}] = count.total();
  from.phase = ParticipantPhase::kDone;
}

void SimClockServer::Impl::answer(Participant& to, const std::string& error) {
  wire::SimClockMessage message;
  message.mutable_ok()->set_error(error);
  to.stream->send(message.SerializeAsString());
}

/// A connection that ends without Leave drops its participant at once; one that ends after it is no news.
void SimClockServer::Impl::drop_closed() {
  std::erase_if(participants, [this](const Participant& p) {
    if (p.phase == ParticipantPhase::kLeaving)
      return !options.is_lockstep;  // in lockstep its last messages are still counted
    const bool is_dropped = !p.stream->is_open();
    if (is_dropped && p.id != 0)
      std::fprintf(stderr, "arm_sim: dropped %s: %s\n", p.name.c_str(), p.stream->close_reason().c_str());
    return is_dropped;
  });
}

SimClockServer::SimClockServer(const SimClockOptions& options, Wishes wishes)
    : impl_(std::make_unique<Impl>(options, std::move(wishes))) {}

SimClockServer::~SimClockServer() = default;

ServerClock& SimClockServer::clock() { return impl_->clock; }

bool SimClockServer::run_participants(const std::function<bool()>& is_stopping) {
  bool is_granted = false;
  while (!impl_->is_finished && !is_stopping()) {
    impl_->serve();
    if (!is_granted && impl_->joined() > 0) {
      impl_->grant_all();
      is_granted = true;
    } else if (is_granted &&
               impl_->all_are({ParticipantPhase::kDone, ParticipantPhase::kLeaving, ParticipantPhase::kJoined})) {
      impl_->hand_on();
      return true;
    }
    // A limit only so that a signal that came just before the wait is heard.
    net::wait_and_flow(impl_->descriptors(), std::chrono::milliseconds(200), &impl_->clock);
  }
  return false;
}

void SimClockServer::serve() { impl_->serve(); }

std::vector<int> SimClockServer::descriptors() const { return impl_->descriptors(); }

bool SimClockServer::is_finished() const { return impl_->is_finished; }

std::size_t SimClockServer::participants() const { return impl_->joined(); }

std::size_t SimClockServer::ever_joined() const {
  const std::lock_guard lock(impl_->crystals_mutex);
  return impl_->crystals.size();
}

std::uint64_t SimClockServer::cycle() const { return impl_->cycle; }

std::uint32_t SimClockServer::last_arm_controller() const { return impl_->last_controller; }

std::int64_t SimClockServer::to_own_ns(std::uint32_t participant, std::int64_t sim_time_ns) const {
  const std::lock_guard lock(impl_->crystals_mutex);
  const auto found = impl_->crystals.find(participant);
  return found == impl_->crystals.end() ? sim_time_ns : found->second.to_own_ns(sim_time_ns);
}

}  // namespace armsight::sim
