// Where was the arm when that picture was taken?
// A fixed ring of (time, q, speed) written each tick and read by the filter, whose pictures are late by a few ticks to
// some tenths of a second. q in rad, raw encoders: the reader adds beta. at(t) interpolates linearly and answers
// nullopt for times the ring no longer, or not yet, holds; nothing is extrapolated.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "shared/arm_model.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

class JointHistory {
 public:
  static constexpr std::size_t kCapacity = 1024;  ///< 4 s at 250 Hz, 2 s at 500 Hz

  static constexpr int kLongestGap = 5;  ///< periods: two bridged samples, and some

  explicit JointHistory(Duration period) noexcept : longest_gap_(kLongestGap * period) {}

  struct Sample {
    Time time;
    JointVector q_rad, speed_rad_s;
  };

  /// Samples not later than the newest one are ignored: time only rises.
  void push(const Sample& sample) noexcept {
    if (count_ > 0 && sample.time <= newest(0).time) return;
    ring_[next_] = sample;
    next_ = (next_ + 1) % kCapacity;
    if (count_ < kCapacity) ++count_;
  }

  std::size_t size() const noexcept { return count_; }
  /// age 0: the newest; precondition: age < size().
  const Sample& newest(std::size_t age) const noexcept { return ring_[(next_ + 2 * kCapacity - 1 - age) % kCapacity]; }

  std::optional<Sample> at(Time t) const noexcept {
    if (count_ == 0 || t > newest(0).time || t < newest(count_ - 1).time) return std::nullopt;
    std::size_t young = 0, old = count_ - 1;  // newest(young).time >= t >= newest(old).time
    while (old - young > 1) {
      const std::size_t middle = (young + old) / 2;
      (newest(middle).time >= t ? young : old) = middle;
    }
    const Sample &b = newest(young), &a = newest(old);
    if (b.time == a.time) return b;
    if (b.time - a.time > longest_gap_) return std::nullopt;
    const double s = to_seconds(t - a.time) / to_seconds(b.time - a.time);
    return Sample{t, a.q_rad + s * (b.q_rad - a.q_rad),
                  a.speed_rad_s.cwiseAbs().cwiseMax(b.speed_rad_s.cwiseAbs())};
  }

 private:
  Duration longest_gap_;
  std::array<Sample, kCapacity> ring_{};
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace armsight::arm
