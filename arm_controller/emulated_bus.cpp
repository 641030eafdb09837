#include "arm_controller/emulated_bus.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "arm_controller/emulated_bus_wire.hpp"
#include "protocol/transport/wait.hpp"

namespace armsight::arm {

namespace {

Descriptor connect_to_hub(const std::string& path, std::uint32_t participant) {
  const auto refuse = [&path](const std::string& reason) {
    throw std::runtime_error("emulated bus " + path + ": " + reason);
  };
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) refuse("the path must have 1 to 107 characters");
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  if (socket.get() < 0) refuse(std::strerror(errno));
  const BusPacketBytes join = encode_bus_join(participant);
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::send(socket.get(), join.data(), join.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(join.size()))
    refuse(std::strerror(errno));
  return socket;
}

class EmulatedBus : public CanBus {
 public:
  EmulatedBus(const std::string& path, net::Clock& clock, int bus)
      : clock_(clock), channel_{net::bus_channel(bus), 0}, name_("emulated:" + path),
        socket_(connect_to_hub(path, clock.participant())) {}

  SendResult send(const CanFrame& frame) noexcept override {
    if (errors_.lost) return SendResult::kBusDown;
    const BusPacketBytes bytes = encode_bus_packet({clock_.is_lockstep() ? 0 : net::monotonic_ns(), frame, 0});
    const ssize_t n = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n == static_cast<ssize_t>(bytes.size())) {
      clock_.count_sent(channel_);
      return SendResult::kSent;
    }
    ++errors_.send_failures;
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) return SendResult::kQueueFull;
    errors_.lost = true;
    return SendResult::kBusDown;
  }

  bool receive(BusFrame& frame) noexcept override {
    while (!errors_.lost) {
      const std::optional<Time> due = next_due();
      if (clock_.is_lockstep() && !due) return false;
      const std::optional<BusPacket> packet = next_packet();
      if (clock_.is_lockstep()) clock_.count_received(channel_);
      if (!packet) return false;
      if (is_notice(*packet)) continue;
      frame = {packet->frame, due ? *due : to_own_time(packet->time_ns), (packet->flags & kFlagOwnEcho) != 0};
      return true;
    }
    return false;
  }

  BusErrors take_errors() noexcept override {
    const BusErrors taken = errors_;
    errors_ = {};
    errors_.lost = taken.lost;  // a hub that is gone stays gone
    return taken;
  }

  const std::string& name() const override { return name_; }

 private:
  std::optional<Time> next_due() const noexcept {
    const auto due = clock_.due(channel_);
    if (due.empty()) return std::nullopt;
    return due.front();
  }

  /// In lockstep the packet was sent before the cycle was granted: waiting is short and cannot be in vain.
  std::optional<BusPacket> next_packet() noexcept {
    BusPacketBytes bytes;
    while (true) {
      const ssize_t n = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (n > 0) return decode_bus_packet(std::span<const char>(bytes.data(), static_cast<std::size_t>(n)));
      const bool is_empty = n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
      if (!is_empty) {
        errors_.lost = true;
        return std::nullopt;
      }
      if (!clock_.is_lockstep()) return std::nullopt;
      const int descriptors[] = {socket_.get()};
      net::wait_and_flow(descriptors, Duration{-1}, &clock_);
    }
  }

  bool is_notice(const BusPacket& packet) noexcept {
    if (packet.flags & kFlagErrorFrame) {
      ++errors_.error_frames;
      if (packet.frame.data[0] == kErrorPassiveState) errors_.error_passive = true;
      if (packet.frame.data[0] == kBusOffState) errors_.bus_off = true;
    }
    if (packet.flags & kFlagDropped) ++errors_.send_failures;
    return (packet.flags & (kFlagErrorFrame | kFlagDropped)) != 0;
  }

  /// Real pace: hub and program share the machine's clock, so the age of a frame is the same on every crystal.
  Time to_own_time(std::int64_t monotonic) const noexcept {
    return clock_.now() - Duration{net::monotonic_ns() - monotonic};
  }

  net::Clock& clock_;
  net::ChannelKey channel_;
  std::string name_;
  Descriptor socket_;
  BusErrors errors_;
};

}  // namespace

std::unique_ptr<CanBus> join_emulated_bus(const std::string& path, net::Clock& clock, int bus) {
  return std::make_unique<EmulatedBus>(path, clock, bus);
}

BusObserver::BusObserver(const std::string& path) : socket_(connect_to_hub(path, 0)) {}

bool BusObserver::receive(BusFrame& frame, Duration timeout) {
  pollfd entry{socket_.get(), POLLIN, 0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count();
  if (!is_open_ || ::poll(&entry, 1, static_cast<int>(ms)) <= 0) return false;
  BusPacketBytes bytes;
  const ssize_t n = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (n <= 0) {
    is_open_ = n < 0 && (errno == EAGAIN || errno == EINTR);
    return false;
  }
  const auto packet = decode_bus_packet(std::span<const char>(bytes.data(), static_cast<std::size_t>(n)));
  if (!packet || packet->flags != 0) return false;
  frame = {packet->frame, time_from_ns(packet->time_ns), false};
  return true;
}

}  // namespace armsight::arm
