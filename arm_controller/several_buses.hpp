// Several CAN buses of one arm as one CanBus: frames carry the number of theirs.
#pragma once

#include <memory>
#include <vector>

#include "arm_controller/can_bus.hpp"

namespace armsight::arm {

/// In the order of their numbers, 1 to kMaxBuses of them. Frames of all come in order of time, at the same instant the
/// lower bus first. One alone is handed back as it is.
std::unique_ptr<CanBus> join_buses(std::vector<std::unique_ptr<CanBus>> buses);

}  // namespace armsight::arm
