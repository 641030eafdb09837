// The emulated CAN bus of arm_sim as seen by a program on it (wire: emulated_bus_wire.hpp).
#pragma once

#include <memory>
#include <string>

#include "arm_controller/can_bus.hpp"
#include "protocol/descriptor.hpp"
#include "protocol/transport/clock.hpp"

namespace armsight::arm {

/// Throws std::runtime_error "emulated bus PATH: reason". The clock must outlive the bus.
/// `bus`: its number among the arm's.
std::unique_ptr<CanBus> join_emulated_bus(const std::string& path, net::Clock& clock, int bus = 0);
/// A listener: sees every frame with the bus' own time, sends nothing.
class BusObserver {
 public:
  explicit BusObserver(const std::string& path);
  /// Waits for the next frame; false: none within the timeout, or the bus is gone.
  bool receive(BusFrame& frame, Duration timeout);
  bool is_open() const { return is_open_; }

 private:
  Descriptor socket_;
  bool is_open_ = true;
};

}  // namespace armsight::arm
