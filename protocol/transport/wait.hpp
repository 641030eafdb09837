// The one poll(2) of the transport: waiting for descriptors while unsent bytes of other streams keep moving.
#pragma once

#include <functional>
#include <span>

#include "protocol/transport/clock.hpp"

namespace armsight::net {

/// Waits until one of the descriptors is readable or the timeout is over (negative: no limit); meanwhile sends what the
/// clock's flows have unsent. Returns false on timeout. clock may be null.
bool wait_and_flow(std::span<const int> descriptors, Duration timeout, Clock* clock);

/// The machine's monotonic clock, ns.
std::int64_t monotonic_ns();
/// Sleeps until that time of the machine's monotonic clock.
void sleep_until_monotonic_ns(std::int64_t time_ns);

}  // namespace armsight::net
