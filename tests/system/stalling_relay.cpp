#include "tests/system/stalling_relay.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace armsight::demo {

namespace {

constexpr int kPoll_ms = 20;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

void must(bool is_well, const char* what) {
  if (!is_well) throw std::runtime_error(std::string(what) + ": " + std::strerror(errno));
}

bool pass_on(int from, int to) {
  std::array<char, 16 * 1024> bytes{};
  const ssize_t size = recv(from, bytes.data(), bytes.size(), 0);
  for (ssize_t sent = 0; sent < size;) {
    const ssize_t n = send(to, bytes.data() + sent, static_cast<std::size_t>(size - sent), MSG_NOSIGNAL);
    if (n < 0) return false;
    sent += n;
  }
  return size > 0;
}

}  // namespace

StallingRelay::StallingRelay(const std::string& controller_address) {
  sockaddr_in own = loopback(0);
  socklen_t size = sizeof own;
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  must(bind(listener_, reinterpret_cast<sockaddr*>(&own), size) == 0 && listen(listener_, 1) == 0, "relay: listen");
  must(getsockname(listener_, reinterpret_cast<sockaddr*>(&own), &size) == 0, "relay: getsockname");
  address_ = "127.0.0.1:" + std::to_string(ntohs(own.sin_port));
  const sockaddr_in controller = loopback(std::stoi(controller_address.substr(controller_address.rfind(':') + 1)));
  ends_[1] = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  must(connect(ends_[1], reinterpret_cast<const sockaddr*>(&controller), sizeof controller) == 0, "relay: connect");
  thread_ = std::jthread([this](const std::stop_token& stop) { relay_until_stopped(stop); });
}

StallingRelay::~StallingRelay() {
  thread_.request_stop();
  thread_.join();
  for (const int descriptor : {listener_, ends_[0], ends_[1]})
    if (descriptor >= 0) close(descriptor);
}

bool StallingRelay::take_host() {
  pollfd waiting{listener_, POLLIN, 0};
  if (poll(&waiting, 1, kPoll_ms) == 1) ends_[0] = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  return ends_[0] >= 0;
}

void StallingRelay::relay_until_stopped(const std::stop_token& stop) {
  while (!take_host())
    if (stop.stop_requested()) return;
  while (!stop.stop_requested()) {
    if (is_stalled_) {
      poll(nullptr, 0, kPoll_ms);
      continue;
    }
    std::array<pollfd, 2> waiting{{{ends_[0], POLLIN, 0}, {ends_[1], POLLIN, 0}}};
    poll(waiting.data(), waiting.size(), kPoll_ms);
    if (is_stalled_) continue;
    for (const std::size_t i : {0U, 1U})
      if (waiting[i].revents != 0 && !pass_on(ends_[i], ends_[1 - i])) return;
  }
}

}  // namespace armsight::demo
