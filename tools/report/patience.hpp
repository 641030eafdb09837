// How long a program may take to come up, to answer, to end. The only use of the machine's clock in a lockstep run, and
// only to give up.
#pragma once

#include <chrono>

namespace armsight::demo {

inline constexpr int kStartPatience_ms = 30'000;
inline constexpr int kPoll_ms = 100;

class Patience {
 public:
  explicit Patience(int limit_ms) : end_(std::chrono::steady_clock::now() + std::chrono::milliseconds(limit_ms)) {}
  bool is_over() const { return std::chrono::steady_clock::now() > end_; }

 private:
  std::chrono::steady_clock::time_point end_;
};

}  // namespace armsight::demo
