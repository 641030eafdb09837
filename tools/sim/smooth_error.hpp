// An error that depends on position: smooth, zero mean, of a given size, different for every seed. Its wavelengths
// (k = 8 … 15 per radian) are short against the distance of two looks, so their errors look independent, and long
// against what an arm moves while it settles.
#pragma once

#include <array>
#include <cmath>

#include "tools/sim/random.hpp"

namespace armsight::sim {

class SmoothError {
 public:
  SmoothError() = default;
  SmoothError(double sigma, Random random) {
    for (Wave& wave : waves_)
      wave = {sigma * std::sqrt(2.0 / static_cast<double>(waves_.size())), random.uniform(8.0, 15.0),
              random.uniform(0.0, 2.0 * std::numbers::pi)};
  }
  double at(double x) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += wave.amplitude * std::sin(wave.k * x + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    double amplitude = 0.0, k = 0.0, phase = 0.0;
  };
  std::array<Wave, 5> waves_{};
};

}  // namespace armsight::sim
