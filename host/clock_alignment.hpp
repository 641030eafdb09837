// What does the arm's clock show when ours shows t? From four stamps an exchange: host send, arm receive, arm send,
// host receive. Of the last 256 exchanges the 16 with the lowest round trip carry a weighted line (offset and skew);
// every answer comes with a bound that holds for any split of the delay between the two directions.
//   controller.md §9: offset = ((t2 − t1) + (t3 − t4)) / 2, round trip = (t4 − t1) − (t3 − t2)
// Pure: time is handed in. The clocks may differ by any offset and by at most kMaxSkew in rate.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "shared/time.hpp"

namespace armsight::host {

/// The four stamps of one heartbeat and its reply.
struct ClockExchange {
  Time host_send, arm_receive, arm_send, host_receive;
};

/// A time on the arm's clock, and by how much it may be off.
struct AlignedTime {
  Time arm_time;
  Duration bound;
};

class ClockAlignment {
 public:
  static constexpr std::size_t kWindow = 256;
  static constexpr std::size_t kFitted = 16;
  static constexpr double kMaxSkew = 200e-6;  ///< two crystals of ±100 ppm
  static constexpr int kStepSamples = 5;      ///< so many exchanges in a row off the line: the clock has stepped

  /// Takes an exchange; one whose stamps run backwards, or lie beyond kMaxWireTime_ns, is dropped and counted.
  void add(const ClockExchange& exchange);

  /// nullopt before the first exchange, and after a step until exchanges came again.
  std::optional<AlignedTime> to_arm(Time host_time) const;
  /// Bound at the newest exchange; nullopt without any.
  std::optional<Duration> bound() const;
  double skew() const { return line_.skew; }
  int steps() const { return steps_; }
  int dropped() const { return dropped_; }

 private:
  struct Sample {
    Time host_middle;          ///< middle of send and receive, own clock
    std::int64_t offset_ns;    ///< arm − host there
    std::int64_t round_trip_ns;
  };
  struct Line {
    Time origin{};              ///< host time at which `offset_ns` holds
    std::int64_t base_ns = 0;   ///< a large common part of all offsets, kept out of the floating point
    double offset_ns = 0.0;
    double skew = 0.0;          ///< d(arm − host)/d(host)
  };

  double residual_ns(const Sample& sample) const;
  double bound_ns(Time host_time) const;
  bool is_off_the_line(const Sample& sample) const;
  void fit();

  std::deque<Sample> window_;
  std::deque<Sample> fitted_;
  Line line_;
  int off_line_in_a_row_ = 0;
  int steps_ = 0;
  int dropped_ = 0;
};

}  // namespace armsight::host
