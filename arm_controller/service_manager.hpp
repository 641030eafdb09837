// Tells systemd that the controller is ready, alive, leaving (sd_notify's datagrams, Type=notify). Without a service
// manager, that is without $NOTIFY_SOCKET, nothing is sent.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstdint>
#include <string_view>

#include "protocol/descriptor.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

class ServiceManager {
 public:
  ServiceManager();

  void say_ready(std::string_view status);
  /// Kicks the watchdog, at most four times in its time ($WATCHDOG_USEC), and only where the cycle went on since the last
  /// kick: a cycle that stands still is thereby ended by the service manager, and the drives stop by their own supervision.
  void say_alive(Time now, std::uint64_t cycles);
  void say_stopping();

 private:
  void send(std::string_view message);

  Descriptor socket_;
  sockaddr_un address_{};
  socklen_t address_size_ = 0;
  Duration kick_period_{0};
  Time last_kick_;
  std::uint64_t last_cycles_ = 0;
};

}  // namespace armsight::arm
