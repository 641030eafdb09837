#include "arm_controller/service_manager.hpp"

#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

namespace armsight::arm {

ServiceManager::ServiceManager() {
  const char* path = std::getenv("NOTIFY_SOCKET");
  const std::size_t length = path == nullptr ? 0 : std::strlen(path);
  if (length < 2 || length >= sizeof address_.sun_path || (path[0] != '/' && path[0] != '@')) return;
  address_.sun_family = AF_UNIX;
  std::memcpy(address_.sun_path, path, length);
  if (path[0] == '@') address_.sun_path[0] = '\0';  // an abstract name
  address_size_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  socket_ = Descriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));

  const char* watchdog_us = std::getenv("WATCHDOG_USEC");
  const char* process = std::getenv("WATCHDOG_PID");
  if (watchdog_us == nullptr || (process != nullptr && std::atol(process) != static_cast<long>(::getpid()))) return;
  kick_period_ = std::chrono::microseconds(std::strtoull(watchdog_us, nullptr, 10) / 4);
}

void ServiceManager::say_ready(std::string_view status) { send("READY=1\nSTATUS=" + std::string(status)); }

void ServiceManager::say_alive(Time now, std::uint64_t cycles) {
  if (kick_period_ <= Duration(0) || cycles == last_cycles_ || now - last_kick_ < kick_period_) return;
  last_kick_ = now;
  last_cycles_ = cycles;
  send("WATCHDOG=1");
}

void ServiceManager::say_stopping() { send("STOPPING=1"); }

void ServiceManager::send(std::string_view message) {
  if (socket_.get() < 0) return;
  // A full queue loses a kick; the next one is a quarter of the watchdog's time away.
  (void)::sendto(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&address_), address_size_);
}

}  // namespace armsight::arm
