#include "tests/arm_controller/socket_rig.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <numbers>
#include <stdexcept>

#include "arm_controller/emulated_bus.hpp"
#include "arm_controller/emulated_bus_wire.hpp"
#include "protocol/transport/wait.hpp"

namespace armsight::arm::test {
namespace {

constexpr std::int64_t kNap_ns = 20'000;
constexpr double kCountsPerTurn = 32768.0;

int listen_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) throw std::runtime_error(path + ": too long for a socket");
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(fd, 1) != 0)
    throw std::runtime_error(path + ": " + std::strerror(errno));
  return fd;
}

}  // namespace

Time AnsweredClock::wait_next_cycle() {
  begin_ns_ = net::monotonic_ns();
  const std::uint64_t cycle = asked.fetch_add(1) + 1;
  do net::sleep_until_monotonic_ns(net::monotonic_ns() + kNap_ns);
  while (answered.load(std::memory_order_acquire) < cycle);
  return time += kPeriod;
}

SocketRig::SocketRig()
    : path_(std::filesystem::path("/tmp") / ("armsight-cycle-" + std::to_string(::getpid()))),
      listener_(listen_at(path_.string())), bus_(join_emulated_bus(path_.string(), clock_)),
      loop_(std::make_unique<ControlLoop>(robot_, nominal_start(robot_), *bus_, *mailboxes_, *tape_, *statistics_)) {
  hub_ = Descriptor(::accept(listener_.get(), nullptr, nullptr));
  BusPacketBytes join;
  ::recv(hub_.get(), join.data(), join.size(), 0);
  drives_ = std::thread([this] { serve(); });
}

SocketRig::~SocketRig() {
  leaves_ = true;
  drives_.join();
  std::filesystem::remove(path_);
}

void SocketRig::order(int busy) {
  fill(inbox_, busy, clock_.time, robot_, state_.q_reading_rad);
  if (inbox_.lease) mailboxes_->lease.put(*inbox_.lease);
  if (inbox_.mode) mailboxes_->mode.put(*inbox_.mode);
  if (inbox_.goal) mailboxes_->goal.put(*inbox_.goal);
  if (inbox_.hand) mailboxes_->hand.put(*inbox_.hand);
  if (inbox_.recalibration) mailboxes_->recalibration.put(*inbox_.recalibration);
  if (inbox_.proposal) mailboxes_->proposal.put(*inbox_.proposal);
  for (std::size_t i = 0; i < inbox_.look_count; ++i) mailboxes_->looks.push(inbox_.looks[i]);
  if (inbox_.stop) mailboxes_->stop.set();
  inbox_.stop = false;
}

void SocketRig::take(BusyOutcome& outcome) {
  if (const auto newest = mailboxes_->state.take()) state_ = *newest;
  while (mailboxes_->events.pop(event_)) outcome.count(event_);
  while (tape_->events.pop(event_)) continue;
  while (tape_->ticks.pop(record_)) continue;
  while (tape_->orders.pop(orders_)) continue;
  tape_->checkpoints.take([](std::uint64_t, std::span<const std::byte>) {});
}

// All that the cycle sent lies in the socket before it asks for answers.
void SocketRig::serve() {
  FakeBus drives(std::vector<double>(6, kCountsPerTurn));
  const std::array<double, 5> q{0.2, -0.1, -0.2, 0.8, 0.1};
  for (int i = 0; i < 5; ++i)
    drives.drive(i + 1).position_counts = q[static_cast<std::size_t>(i)] / (2.0 * std::numbers::pi) * kCountsPerTurn;
  BusPacketBytes bytes;
  BusFrame answer;
  while (!leaves_) {
    const std::uint64_t asked = clock_.asked.load();
    if (asked == clock_.answered.load()) {
      net::sleep_until_monotonic_ns(net::monotonic_ns() + kNap_ns);
      continue;
    }
    while (::recv(hub_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT) > 0)
      if (const auto packet = decode_bus_packet(std::span<const char>(bytes)); packet)
        drives.send(packet->frame);
    drives.sent.clear();
    while (drives.receive(answer)) {
      const std::uint8_t flags = answer.is_own_echo ? kFlagOwnEcho : 0;
      bytes = encode_bus_packet({clock_.sync_ns(), answer.frame, flags});
      ::send(hub_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    }
    clock_.answered.store(asked, std::memory_order_release);
  }
}

}  // namespace armsight::arm::test
