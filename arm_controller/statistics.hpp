// How long did the ticks take? Fixed logarithmic buckets, written by the cycle, read by the link: no lock, no heap.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace armsight::arm {

class TickHistogram {
 public:
  /// Eight buckets an octave from 0.1 µs on: a quantile is right to 9 %.
  static constexpr int kBuckets = 192, kPerOctave = 8;
  static constexpr double kSmallest_us = 0.1;

  void add(double us) noexcept {
    const double octaves = us > kSmallest_us ? std::log2(us / kSmallest_us) : 0.0;
    const int bucket = std::min(kBuckets - 1, static_cast<int>(octaves * kPerOctave));
    counts_[static_cast<std::size_t>(bucket)].fetch_add(1, std::memory_order_relaxed);
    total_.fetch_add(1, std::memory_order_relaxed);
  }

  /// Upper edge of the bucket that holds the quantile; 0 without samples.
  double quantile_us(double fraction) const noexcept {
    const double wanted = fraction * static_cast<double>(total_.load(std::memory_order_relaxed));
    double seen = 0.0;
    for (int i = 0; i < kBuckets && wanted > 0.0; ++i) {
      seen += static_cast<double>(counts_[static_cast<std::size_t>(i)].load(std::memory_order_relaxed));
      if (seen >= wanted) return kSmallest_us * std::exp2(static_cast<double>(i + 1) / kPerOctave);
    }
    return 0.0;
  }

 private:
  std::array<std::atomic<std::uint32_t>, kBuckets> counts_{};
  std::atomic<std::uint64_t> total_{0};
};

struct LoopStatistics {
  TickHistogram tick;
  std::atomic<std::uint64_t> cycles{0};
  std::atomic<std::uint64_t> missed{0};
  std::atomic<std::uint64_t> bus_send_failures{0};
  std::atomic<std::uint64_t> tape_overflows{0};
};

}  // namespace armsight::arm
