// The truth of a run, written when it is over: truth.json and beside it the trace, one row a SYNC.
#pragma once

#include <functional>
#include <string>

#include "tools/sim/world.hpp"

namespace armsight::sim {

/// Simulated time → the controller's clock.
using ToArmClock = std::function<std::int64_t(Time time)>;

/// Throws std::runtime_error "FILE: reason".
void write_truth(const World& world, const std::string& file, const ToArmClock& to_arm, Time end);

}  // namespace armsight::sim
