// A cable between host and controller that can be cut without either end noticing: passes bytes on until stall(), then
// neither reads nor closes. What a TCP connection looks like whose peer's machine has lost power.
#pragma once

#include <array>
#include <atomic>
#include <string>
#include <thread>

namespace armsight::demo {

class StallingRelay {
 public:
  /// Listens on a port of its own for one host; throws std::runtime_error where sockets fail.
  explicit StallingRelay(const std::string& controller_address);
  ~StallingRelay();
  StallingRelay(const StallingRelay&) = delete;
  StallingRelay& operator=(const StallingRelay&) = delete;

  const std::string& address() const { return address_; }
  void stall() { is_stalled_ = true; }

 private:
  void relay_until_stopped(const std::stop_token& stop);
  bool take_host();

  std::string address_;
  int listener_ = -1;
  std::array<int, 2> ends_{-1, -1};  ///< host, controller
  std::atomic<bool> is_stalled_ = false;
  std::jthread thread_;
};

}  // namespace armsight::demo
