// One line of the benchmark table, and how it is timed: thread CPU time, ours and the peer's blocks in turn, the median
// of the blocks. So a busy machine slows both and the ratio stands.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace armsight::bench {

struct Row {
  std::string name, unit;
  double ours = 0.0;
  std::optional<double> peer;
  std::string peer_name;
  std::string bar;            ///< in words; empty: none
  std::optional<bool> holds;  ///< nullopt: no bar
  std::string why;            ///< why it could not run, or what else is to be known
};

inline double thread_time_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What a command printed.
inline std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  char line[256];
  while (std::fgets(line, sizeof line, pipe) != nullptr) text += line;
  ::pclose(pipe);
  return text;
}

/// Keeps the compiler from leaving out what computes `value`.
template <class T>
void keep(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

using Work = std::function<void(std::size_t)>;  ///< does input i once

struct Paired {
  double ours_us = 0.0, peer_us = 0.0;  ///< a call
};

/// Medians over `blocks` blocks, each over all inputs; `peer` may be empty.
inline Paired time_paired(std::size_t inputs, int blocks, const Work& ours, const Work& peer = {}) {
  const auto block = [&](const Work& work) {
    const double start = thread_time_us();
    for (std::size_t i = 0; i < inputs; ++i) work(i);
    return (thread_time_us() - start) / static_cast<double>(inputs);
  };
  std::vector<double> our_times, peer_times;
  for (int k = 0; k < blocks; ++k) {
    our_times.push_back(block(ours));
    if (peer) peer_times.push_back(block(peer));
  }
  return {median(our_times), peer ? median(peer_times) : 0.0};
}

std::vector<Row> kinematics_rows(bool is_quick);
std::vector<Row> controller_rows(bool is_quick);
std::vector<Row> program_rows(bool is_quick);
std::vector<Row> stop_rows(bool is_quick);
std::vector<Row> wake_up_rows(bool is_quick);
std::vector<Row> client_rows(bool is_quick);

}  // namespace armsight::bench
