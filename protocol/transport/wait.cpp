// ppoll(2) is Linux' own: poll(2) in nanoseconds.
#include "protocol/transport/wait.hpp"

#include <poll.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <vector>

#include "protocol/transport/framed_stream.hpp"

namespace armsight::net {

namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::vector<pollfd> to_poll(std::span<const int> descriptors, Clock* clock, std::vector<Flow*>& flowing) {
  std::vector<pollfd> entries;
  for (int descriptor : descriptors) entries.push_back({descriptor, POLLIN, 0});
  if (clock == nullptr) return entries;
  for (Flow* flow : clock->flows()) {
    if (!flow->has_unsent()) continue;
    flowing.push_back(flow);
    entries.push_back({flow->flow_descriptor(), POLLOUT, 0});
  }
  return entries;
}

}  // namespace

std::int64_t monotonic_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond_ns + t.tv_nsec;
}

void sleep_until_monotonic_ns(std::int64_t time_ns) {
  const timespec t{time_ns / kSecond_ns, time_ns % kSecond_ns};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

bool wait_and_flow(std::span<const int> descriptors, Duration timeout, Clock* clock) {
  const bool has_limit = timeout >= Duration::zero();
  const std::int64_t deadline_ns = has_limit ? monotonic_ns() + timeout.count() : 0;
  while (true) {
    std::vector<Flow*> flowing;
    std::vector<pollfd> entries = to_poll(descriptors, clock, flowing);
    const std::int64_t remaining_ns = std::max<std::int64_t>(0, deadline_ns - monotonic_ns());
    const timespec limit{remaining_ns / kSecond_ns, remaining_ns % kSecond_ns};
    const int ready = ::ppoll(entries.data(), entries.size(), has_limit ? &limit : nullptr, nullptr);
    if (ready < 0 && errno != EINTR) return false;
    for (std::size_t i = 0; ready > 0 && i < flowing.size(); ++i)
      if (entries[descriptors.size() + i].revents != 0) flowing[i]->send_more();
    for (std::size_t i = 0; ready > 0 && i < descriptors.size(); ++i)
      if (entries[i].revents != 0) return true;
    if (has_limit && monotonic_ns() >= deadline_ns) return false;
    if (ready < 0) return false;  // a signal: the caller looks whether it has to stop
  }
}

void wait_readable(std::span<const int> descriptors, Duration timeout) {
  wait_and_flow(descriptors, timeout, nullptr);
}

}  // namespace armsight::net
