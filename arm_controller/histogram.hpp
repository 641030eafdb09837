// How often did a duration fall where? Fixed log-linear buckets: exact below 64 ns, then 32 buckets an octave, so a
// bucket's upper edge is at most 1/32 above what fell into it. One writer, any number of readers; no lock, no heap.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>

#include "shared/time.hpp"

namespace armsight::arm {

class Histogram {
 public:
  static constexpr int kOctaveBits = 5, kLargestShift = 29;  ///< up to 2^35 ns, 34 s; what is longer is counted as that
  static constexpr std::size_t kPerOctave = std::size_t{1} << kOctaveBits;
  static constexpr std::size_t kBuckets = kPerOctave * (kLargestShift + 2);

  static constexpr std::size_t bucket_of(std::int64_t ns) noexcept {
    constexpr std::int64_t kLongest = (std::int64_t{1} << (kLargestShift + kOctaveBits + 1)) - 1;
    const auto value = static_cast<std::uint64_t>(std::clamp<std::int64_t>(ns, 0, kLongest));
    const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - 1 - kOctaveBits);
    return static_cast<std::size_t>(shift) * kPerOctave + static_cast<std::size_t>(value >> shift);
  }
  /// The longest duration that falls into it.
  static constexpr std::int64_t upper_ns(std::size_t bucket) noexcept {
    const std::size_t shift = bucket < 2 * kPerOctave ? 0 : bucket / kPerOctave - 1;
    return static_cast<std::int64_t>(((bucket - shift * kPerOctave + 1) << shift) - 1);
  }

  /// Of the one writer. A negative duration counts as none.
  void add(Duration duration) noexcept {
    const std::int64_t ns = std::max<std::int64_t>(0, duration.count());
    std::atomic<std::uint64_t>& bucket = counts_[bucket_of(ns)];
    bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (ns > longest_ns_.load(std::memory_order_relaxed)) longest_ns_.store(ns, std::memory_order_relaxed);
  }

  std::uint64_t count() const noexcept {
    std::uint64_t total = 0;
    for (const auto& count : counts_) total += count.load(std::memory_order_relaxed);
    return total;
  }
  /// The smallest bucket edge that at least this share of the durations do not exceed, never above longest_ns().
  std::int64_t quantile_ns(double share) const noexcept {
    const auto wanted = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count()))));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i)
      if ((seen += counts_[i].load(std::memory_order_relaxed)) >= wanted) return std::min(upper_ns(i), longest_ns());
    return longest_ns();
  }
  std::int64_t longest_ns() const noexcept { return longest_ns_.load(std::memory_order_relaxed); }
  /// on_bucket(upper_ns, count) for each bucket that is not empty, from the shortest on.
  template <typename OnBucket>
  void for_each(OnBucket&& on_bucket) const {
    for (std::size_t i = 0; i < kBuckets; ++i)
      if (const std::uint64_t count = counts_[i].load(std::memory_order_relaxed)) on_bucket(upper_ns(i), count);
  }

 private:
  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
  std::atomic<std::int64_t> longest_ns_{0};
};

}  // namespace armsight::arm
