#include <algorithm>

#include "protocol/transport/socket_stream.hpp"
#include "protocol/transport/wait.hpp"

namespace armsight::net {

namespace {

/// How long, in wall time, a peer that owes messages may have no connection at all before they count as lost. Only a
/// stranger that connects and says nothing can make us wait that long.
constexpr Duration kPatience = std::chrono::seconds(2);

struct Peer {
  std::unique_ptr<SocketStream> stream;
  std::uint32_t id = 0;         ///< sim participant, once introduced
  bool is_introduced = false;
  bool is_reported_closed = false;
  int receives_after_close = 0;
};

}  // namespace

struct StreamServer::Impl {
  std::unique_ptr<Listener> listener;
  ChannelKind kind;
  StreamOptions options;
  Clock& clock;
  Introduce introduce;
  std::size_t max_streams;
  std::vector<Peer> peers;               ///< in order of connecting
  std::vector<FramedStream*> open;

  void accept_all();
  void introduce_all();
  void read_all();
  void forget_reported();
  void list_open();
  std::vector<int> descriptors() const;

  void receive_now(std::vector<Event>& events);
  void receive_due(ChannelKey channel, std::vector<Event>& events);
  std::size_t queued_from(std::uint32_t id) const;
  bool may_still_come(std::uint32_t id) const;
  bool has_open_stream(std::uint32_t id) const;
  void take_due(ChannelKey channel, std::span<const Time> arrivals, std::vector<Event>& events);
  void report_closed(std::vector<Event>& events);
  bool may_hand_out_more(Peer& peer) const;
};

void StreamServer::Impl::accept_all() {
  while (auto accepted = listener->accept(options, clock)) {
    std::unique_ptr<SocketStream> stream(static_cast<SocketStream*>(accepted.release()));
    const auto live = std::count_if(peers.begin(), peers.end(), [](const Peer& p) { return p.stream->is_open(); });
    if (static_cast<std::size_t>(live) >= max_streams) {
      stream->close("too many connections");
      continue;
    }
    peers.push_back({std::move(stream)});
  }
}

void StreamServer::Impl::introduce_all() {
  for (Peer& peer : peers) {
    if (peer.is_introduced || peer.stream->queued() == 0) continue;
    peer.id = introduce(peer.stream->front());
    peer.is_introduced = true;
    if (peer.id != 0) peer.stream->set_channel({kind, peer.id});
  }
}

void StreamServer::Impl::read_all() {
  accept_all();
  for (Peer& peer : peers) {
    peer.stream->send_more();
    peer.stream->read_available();
  }
  introduce_all();
}

void StreamServer::Impl::forget_reported() {
  std::erase_if(peers, [](const Peer& peer) { return peer.is_reported_closed; });
}

void StreamServer::Impl::list_open() {
  open.clear();
  for (const Peer& peer : peers)
    if (peer.is_introduced && peer.stream->is_open()) open.push_back(peer.stream.get());
}

std::vector<int> StreamServer::Impl::descriptors() const {
  std::vector<int> all{listener->descriptor()};
  for (const Peer& peer : peers)
    if (peer.stream->is_open()) all.push_back(peer.stream->descriptor());
  return all;
}

/// What arrived from peers without an account: everybody at real pace, strangers to the simulated clock in lockstep.
void StreamServer::Impl::receive_now(std::vector<Event>& events) {
  for (Peer& peer : peers) {
    if (!peer.is_introduced || (clock.is_lockstep() && peer.id != 0)) continue;
    for (std::size_t i = 0; i < options.max_messages_at_once && peer.stream->queued() > 0; ++i) {
      Received message{peer.stream->pop(), clock.now()};
      events.push_back({peer.stream.get(), false, std::move(message)});
    }
  }
}

std::size_t StreamServer::Impl::queued_from(std::uint32_t id) const {
  std::size_t sum = 0;
  for (const Peer& peer : peers)
    if (peer.is_introduced && peer.id == id) sum += peer.stream->queued();
  return sum;
}

bool StreamServer::Impl::has_open_stream(std::uint32_t id) const {
  return std::any_of(peers.begin(), peers.end(), [id](const Peer& peer) {
    return peer.is_introduced && peer.id == id && peer.stream->is_open();
  });
}

/// A peer's connection is in our backlog before it reports that it sent something, so with neither an open stream of
/// its own nor one that has not said yet whose it is, nothing more will come.
bool StreamServer::Impl::may_still_come(std::uint32_t id) const {
  return has_open_stream(id) || std::any_of(peers.begin(), peers.end(), [](const Peer& peer) {
           return !peer.is_introduced && peer.stream->is_open();
         });
}

void StreamServer::Impl::take_due(ChannelKey channel, std::span<const Time> arrivals, std::vector<Event>& events) {
  std::size_t next = 0;
  for (Peer& peer : peers) {
    if (!peer.is_introduced || peer.id != channel.peer) continue;
    while (next < arrivals.size() && peer.stream->queued() > 0) {
      events.push_back({peer.stream.get(), false, Received{peer.stream->pop(), arrivals[next++]}});
    }
  }
  for (std::size_t i = 0; i < arrivals.size(); ++i) clock.count_received(channel);
}

void StreamServer::Impl::receive_due(ChannelKey channel, std::vector<Event>& events) {
  const std::span<const Time> due = clock.due(channel);
  const std::vector<Time> arrivals(due.begin(), due.end());
  const std::int64_t give_up_ns = monotonic_ns() + kPatience.count();
  while (queued_from(channel.peer) < arrivals.size() && may_still_come(channel.peer)) {
    const bool is_patient = has_open_stream(channel.peer);
    if (!is_patient && monotonic_ns() > give_up_ns) break;
    wait_and_flow(descriptors(), is_patient ? Duration{-1} : kPatience, &clock);
    read_all();
  }
  take_due(channel, arrivals, events);
}

/// Of a closed stream that still holds messages. In lockstep they may be due in the next cycle; after that they were
/// never reported as sent (their sender died in that cycle) and never act.
bool StreamServer::Impl::may_hand_out_more(Peer& peer) const {
  constexpr int kLastDue = 2;
  if (!peer.is_introduced) return false;
  return !clock.is_lockstep() || ++peer.receives_after_close <= kLastDue;
}

/// A stream is reported closed once its last message was handed out.
void StreamServer::Impl::report_closed(std::vector<Event>& events) {
  for (Peer& peer : peers) {
    if (peer.stream->is_open()) continue;
    if (peer.stream->queued() > 0 && may_hand_out_more(peer)) continue;
    peer.is_reported_closed = true;
    if (peer.is_introduced) events.push_back({peer.stream.get(), true, {}});
  }
}

StreamServer::StreamServer(const std::string& address, ChannelKind kind, const StreamOptions& options, Clock& clock,
                           Introduce introduce, std::size_t max_streams)
    : impl_(new Impl{listen_tcp(address), kind, options, clock, std::move(introduce), max_streams, {}, {}}) {}

StreamServer::~StreamServer() = default;

std::vector<StreamServer::Event> StreamServer::receive() {
  impl_->forget_reported();
  impl_->read_all();
  std::vector<Event> events;
  impl_->receive_now(events);
  if (impl_->clock.is_lockstep()) {
    const std::span<const ChannelKey> due = impl_->clock.due_channels(impl_->kind);
    const std::vector<ChannelKey> channels(due.begin(), due.end());
    for (const ChannelKey channel : channels) impl_->receive_due(channel, events);
  }
  impl_->report_closed(events);
  impl_->list_open();
  return events;
}

std::span<FramedStream* const> StreamServer::streams() const { return impl_->open; }

std::vector<int> StreamServer::descriptors() const { return impl_->descriptors(); }

std::uint16_t StreamServer::port() const { return impl_->listener->port(); }

}  // namespace armsight::net
