// Seeded differences between the participants: how their clocks run, how long their messages travel.
#include <algorithm>

#include "tools/sim/random.hpp"
#include "tools/sim/sim_clock_server.hpp"

namespace armsight::sim {

net::Crystal make_crystal(std::uint64_t seed, std::uint32_t participant, bool is_conductor) {
  if (is_conductor) return {};
  Random random(seed, kForCrystal, participant);
  const auto offset_ns = static_cast<std::int64_t>(random.uniform(-1e9, 1e9));
  const auto skew_ppb = static_cast<std::int32_t>(random.uniform(-50'000, 50'000));
  return {offset_ns, skew_ppb};
}

std::vector<Time> link_arrivals(std::uint64_t seed, std::uint32_t sender, std::uint32_t receiver, std::uint64_t first,
                                std::size_t count, Time cycle_start, Duration period) {
  const double longest_ns = std::min(3e6, 0.9 * static_cast<double>(period.count()));
  std::vector<Time> arrivals;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t pair = (static_cast<std::uint64_t>(sender) << 32) | receiver;
    Random random(mix(seed ^ pair), kForLinkDelay, first + i);
    arrivals.push_back(cycle_start + Duration{static_cast<std::int64_t>(random.uniform(0.05e6, longest_ns))});
  }
  std::sort(arrivals.begin(), arrivals.end());
  return arrivals;
}

}  // namespace armsight::sim
