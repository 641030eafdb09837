// enable, disable, clear: power and latched faults, nothing else. Each takes the lease first; nothing moves by them,
// but an arm without brakes sinks when its power goes.
#pragma once

#include <iosfwd>

#include "host/host_io.hpp"

namespace armsight::host {

/// Power on, holding where it stands.
void run_enable(HostIo& io, bool clear_fault, std::ostream& out);
/// Power off. An arm under way is refused: stop it first.
void run_disable(HostIo& io, std::ostream& out);
/// Clears the latched fault; the power stays off. Throws CommandFailed where the fault comes back.
void run_clear(HostIo& io, std::ostream& out);

}  // namespace armsight::host
