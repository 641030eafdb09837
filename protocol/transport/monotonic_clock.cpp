// Real pace: cycles on the machine's monotonic clock, alone or through the crystal that arm_sim announced.
#include "protocol/transport/monotonic_clock.hpp"

#include "protocol/transport/wait.hpp"

namespace armsight::net {

std::int64_t Crystal::to_own_ns(std::int64_t monotonic) const {
  return monotonic + offset_ns + scaled(monotonic, skew_ppb);
}

std::int64_t Crystal::to_monotonic_ns(std::int64_t own) const {
  // One Newton step is exact to skew² · the age of the machine: nanoseconds.
  const std::int64_t guess = own - offset_ns - scaled(own - offset_ns, skew_ppb);
  return guess + (own - to_own_ns(guess));
}

std::int64_t Crystal::scaled(std::int64_t ns, std::int32_t ppb) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  return (ns / kSecond) * ppb + (ns % kSecond) * ppb / kSecond;
}

MonotonicClock::MonotonicClock(Crystal crystal, Duration period)
    : crystal_(crystal), period_ns_(period.count()), next_ns_(to_ns(now()) + period.count()) {}

Time MonotonicClock::now() const { return time_from_ns(crystal_.to_own_ns(monotonic_ns())); }

Time MonotonicClock::wait_next_cycle() {
  const std::int64_t late_ns = to_ns(now()) - next_ns_;
  if (late_ns >= period_ns_) {  // less is made up for by the next cycle
    const std::int64_t skipped = late_ns / period_ns_;
    missed_.fetch_add(static_cast<std::uint64_t>(skipped), std::memory_order_relaxed);
    next_ns_ += skipped * period_ns_;
  }
  sleep_until_monotonic_ns(crystal_.to_monotonic_ns(next_ns_));
  const Time begin = now();
  lateness_ = begin - time_from_ns(next_ns_);
  next_ns_ += period_ns_;
  return begin;
}

std::unique_ptr<Clock> make_monotonic_clock(Duration period) {
  return std::make_unique<MonotonicClock>(Crystal{-monotonic_ns(), 0}, period);
}

}  // namespace armsight::net
