#include "protocol/bus_traffic.hpp"

#include <algorithm>

#include "protocol/bus_budget.hpp"

namespace armsight {

namespace {

constexpr std::int64_t kWindow_ns = 100'000'000;

}  // namespace

void BusTraffic::add(const CanFrame& frame, Time end) {
  const int bits = stuffed_bits(frame), worst = worst_case_bits(frame.size);
  if (!first_) {
    first_ = end;  // its own bits lie before the time that is looked at
  } else {
    SeenMessage& seen = messages_[frame.id];
    ++seen.count;
    seen.bits += bits;
    seen.worst_case_bits += worst;
    seen.most_bits = std::max(seen.most_bits, bits);
    const std::int64_t window = (to_ns(end) - to_ns(*first_)) / kWindow_ns;
    window_bits_ = window == window_ ? window_bits_ + bits : bits;
    window_ = window;
    highest_load_ = std::max(highest_load_, share(window_bits_, 1e-9 * kWindow_ns));
  }
  last_ = end;
  if (frame.id == kSyncId) sync_begin_ = end - seconds_to_duration(worst / bitrate_bit_s_);
  if (!sync_begin_) return;
  std::optional<double>& latest_s = messages_[frame.id].latest_s;
  latest_s = std::max(latest_s.value_or(0.0), to_seconds(end - *sync_begin_));
}

double BusTraffic::duration_s() const { return first_ ? to_seconds(*last_ - *first_) : 0.0; }

double BusTraffic::share(std::int64_t bits, double duration_s) const {
  return duration_s > 0.0 ? static_cast<double>(bits) / bitrate_bit_s_ / duration_s : 0.0;
}

double BusTraffic::load() const {
  std::int64_t bits = 0;
  for (const auto& [id, seen] : messages_) bits += seen.bits;
  return share(bits, duration_s());
}

double BusTraffic::worst_case_load() const {
  std::int64_t bits = 0;
  for (const auto& [id, seen] : messages_) bits += seen.worst_case_bits;
  return share(bits, duration_s());
}

}  // namespace armsight
