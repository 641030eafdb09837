// Chance that depends on its name only: the same seed and the same question give the same answer, whatever else was
// drawn before. So a new source of noise leaves the others as they were.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "shared/geometry.hpp"

namespace armsight::sim {

inline constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15ULL;
/// splitmix64: every bit of the input moves every bit of the output.
constexpr std::uint64_t mix(std::uint64_t x) {
  x += kStep;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// A stream of random numbers named by a seed, a purpose and an index.
class Random {
 public:
  constexpr Random(std::uint64_t seed, std::uint64_t purpose, std::uint64_t index = 0)
      : state_(mix(mix(mix(seed) ^ purpose) ^ index)) {}

  constexpr std::uint64_t bits() {
    const std::uint64_t drawn = mix(state_);
    state_ += kStep;
    return drawn;
  }
  /// In [0, 1).
  constexpr double unit() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  constexpr double uniform(double low, double high) { return low + (high - low) * unit(); }
  /// Standard normal (Box-Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - unit()));
    return radius * std::cos(2.0 * std::numbers::pi * unit());
  }
  Vector3 direction() {
    const Vector3 v(normal(), normal(), normal());
    return v.normalized();
  }

 private:
  std::uint64_t state_;
};

/// What chance is asked about; the values are part of every seed's meaning.
enum Purpose : std::uint64_t {
  kForBeta = 1, kForCamera, kForMarkerMount, kForLinks, kForDrift, kForEncoder, kForJitter, kForServo, kForStart,
  kForObject, kForCrystal, kForLinkDelay
};

}  // namespace armsight::sim
