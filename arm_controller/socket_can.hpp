// The CAN interface of the kernel. The only file that knows PF_CAN (controller.md §4.7).
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "arm_controller/can_bus.hpp"
#include "protocol/transport/clock.hpp"

namespace armsight::arm {

/// A bus that is not there; what() says which and why. Caught in main: exit code 3.
class BusError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the kernel lets through: what concerns a controller, or everything (drives, listeners).
enum class CanHears { kController, kEverything };

/// "can0": opened raw, with error frames, our own frames seen back, non-blocking; a controller takes
/// CAN FD frames only where they are asked for, and then the interface must know them. Throws BusError.
std::unique_ptr<CanBus> open_socket_can(const std::string& interface, net::Clock& clock,
                                        CanHears hears = CanHears::kController, bool speaks_fd = false);

}  // namespace armsight::arm
