#include "tools/sim/bus_hub.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "arm_controller/emulated_bus_wire.hpp"

namespace armsight::sim {

namespace {

using arm::BusPacket;
using arm::BusPacketBytes;

int listen_at(const std::string& path) {
  const auto refuse = [&path](const std::string& reason) {
    throw std::runtime_error("emulated bus " + path + ": " + reason);
  };
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) refuse("the path must have 1 to 107 characters");
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const auto* raw = reinterpret_cast<const sockaddr*>(&address);
  const int probe = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  const bool is_stale = ::connect(probe, raw, sizeof address) != 0 && errno == ECONNREFUSED;
  ::close(probe);
  struct stat status{};
  if (is_stale && ::stat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) ::unlink(path.c_str());
  const int descriptor = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0 || ::bind(descriptor, raw, sizeof address) != 0 || ::listen(descriptor, 16) != 0) {
    const int error = errno;
    ::close(descriptor);
    refuse(std::strerror(error));
  }
  return descriptor;
}

/// A program on the bus. port 0: an observer.
struct Client {
  int descriptor = -1;
  int port = 0;
  std::uint32_t participant = 0;
  bool is_joined = false;
  bool is_open = true;
  bool is_broken = false;  ///< found while delivering, closed with the next receive()
};

}  // namespace

struct BusHub::Impl {
  std::string path;
  BusModel& bus;
  ServerClock& clock;
  ToOwnClock to_own;
  net::ChannelKind channel;
  int listener;
  std::vector<std::unique_ptr<Client>> clients;
  std::uint64_t dropped = 0;

  void accept_all();
  void take_join(Client& client, std::span<const char> bytes);
  void take_available(Client& client);
  void take_frame(Client& client, std::span<const char> bytes);
  void take_due(net::ChannelKey sender);
  bool take_packet(Client& client);
  void deliver(Client& client, const CanFrame& frame, Time end, std::uint8_t flags);
  void close(Client& client);
  void forget_closed();
};

BusHub::BusHub(const std::string& path, BusModel& bus, ServerClock& clock, ToOwnClock to_own, int number)
    : impl_(new Impl{path, bus, clock, std::move(to_own), net::bus_channel(number), listen_at(path), {}, 0}) {}

BusHub::~BusHub() {
  for (auto& client : impl_->clients) impl_->close(*client);
  ::close(impl_->listener);
  ::unlink(impl_->path.c_str());
}

void BusHub::Impl::accept_all() {
  while (true) {
    const int descriptor = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (descriptor < 0) return;
    clients.push_back(std::make_unique<Client>());
    clients.back()->descriptor = descriptor;
  }
}

void BusHub::Impl::close(Client& client) {
  if (!client.is_open) return;
  client.is_open = false;
  ::close(client.descriptor);
  client.descriptor = -1;
  if (client.port != 0) bus.remove_port(client.port);
}

void BusHub::Impl::forget_closed() {
  std::erase_if(clients, [](const auto& client) { return !client->is_open; });
}

void BusHub::Impl::deliver(Client& client, const CanFrame& frame, Time end, std::uint8_t flags) {
  if (!client.is_open || client.is_broken) return;
  const std::int64_t time_ns =
      clock.is_lockstep() ? to_own(client.participant, to_ns(end)) : to_ns(end);
  const BusPacketBytes bytes = arm::encode_bus_packet({time_ns, frame, flags});
  const ssize_t n = ::send(client.descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (n != static_cast<ssize_t>(bytes.size())) {
    ++dropped;  // a program that does not read loses frames, as on a real interface
    client.is_broken = n < 0 && (errno == EPIPE || errno == ECONNRESET);
    return;
  }
  if (client.participant != 0) clock.count_sent_at({channel, client.participant}, end);
}

/// An observer in lockstep has no account, so its frames could act at no certain time: it may only listen.
void BusHub::Impl::take_join(Client& client, std::span<const char> bytes) {
  const auto participant = arm::decode_bus_join(bytes);
  if (!participant) return close(client);
  client.participant = *participant;
  client.is_joined = true;
  Client* stable = &client;
  client.port = bus.add_port(
      [this, stable](const CanFrame& frame, Time end, bool is_own_echo) {
        deliver(*stable, frame, end, is_own_echo ? arm::kFlagOwnEcho : std::uint8_t{0});
      },
      BusModel::Order::kAsQueued,
      [this, stable](PortState state, Time time) {
        CanFrame notice;
        notice.size = 1;
        notice.data[0] = static_cast<std::uint8_t>(state);
        deliver(*stable, notice, time, arm::kFlagErrorFrame);
      });
}

void BusHub::Impl::take_frame(Client& client, std::span<const char> bytes) {
  const auto packet = arm::decode_bus_packet(bytes);
  if (!packet) return close(client);
  if (clock.is_lockstep() && client.participant == 0) return;
  if (!bus.send(client.port, packet->frame, clock.now()))
    deliver(client, packet->frame, clock.now(), arm::kFlagDropped);
}

/// One packet, if there is one. False: none, or the program is gone.
bool BusHub::Impl::take_packet(Client& client) {
  BusPacketBytes bytes;
  const ssize_t n = ::recv(client.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return false;
  if (n != static_cast<ssize_t>(bytes.size())) {
    close(client);
    return false;
  }
  if (client.is_joined) take_frame(client, bytes);
  else take_join(client, bytes);
  return client.is_open;
}

void BusHub::Impl::take_available(Client& client) {
  while (client.is_open && take_packet(client)) {
  }
}

void BusHub::Impl::take_due(net::ChannelKey sender) {
  const std::size_t due = clock.due(sender).size();
  for (std::size_t i = 0; i < due; ++i) clock.count_received(sender);
  const auto found = std::find_if(clients.begin(), clients.end(), [sender](const auto& client) {
    return client->is_open && client->participant == sender.peer;
  });
  if (found == clients.end()) return;
  Client& client = **found;
  for (std::size_t taken = 0; taken < due && client.is_open;) {
    if (take_packet(client)) {
      ++taken;
    } else if (client.is_open) {
      const int descriptors[] = {client.descriptor};
      net::wait_and_flow(descriptors, Duration{-1}, &clock);
    }
  }
}

void BusHub::receive() {
  Impl& hub = *impl_;
  hub.accept_all();
  const bool is_lockstep = hub.clock.is_lockstep();
  for (auto& client : hub.clients) {
    if (client->is_broken) hub.close(*client);
    if (client->is_open && !client->is_joined) hub.take_packet(*client);
    const bool has_account = is_lockstep && client->participant != 0;
    if (client->is_open && client->is_joined && !has_account) hub.take_available(*client);
  }
  if (is_lockstep) {
    const auto due = hub.clock.due_channels(hub.channel);
    const std::vector<net::ChannelKey> channels(due.begin(), due.end());
    for (const net::ChannelKey channel : channels) hub.take_due(channel);
  }
  hub.forget_closed();
}

std::vector<int> BusHub::descriptors() const {
  std::vector<int> all{impl_->listener};
  for (const auto& client : impl_->clients) all.push_back(client->descriptor);
  return all;
}

std::uint64_t BusHub::frames_dropped() const { return impl_->dropped; }

}  // namespace armsight::sim
