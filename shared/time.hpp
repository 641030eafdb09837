// Points in time on a clock that nobody can read.
// Pure code is *given* the time; only the programs' Clock (protocol/transport/clock.hpp) can read one. Nanoseconds.
#pragma once

#include <chrono>
#include <cstdint>

namespace armsight {

/// A steady clock without now(): a Time can be passed on and compared, never asked for.
struct UnreadableClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<UnreadableClock>;
  static constexpr bool is_steady = true;
};

using Duration = std::chrono::nanoseconds;
using Time = UnreadableClock::time_point;

constexpr Time time_from_ns(std::int64_t ns) { return Time{Duration{ns}}; }
constexpr std::int64_t to_ns(Time t) { return t.time_since_epoch().count(); }
constexpr double to_seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
constexpr Duration seconds_to_duration(double s) { return Duration{static_cast<std::int64_t>(s * 1e9)}; }

}  // namespace armsight
