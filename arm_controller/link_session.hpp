// One peer of the link: who it is, what it may, and how its clock stands to ours.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "protocol/transport/framed_stream.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

struct LinkSession {
  static constexpr int kMaxProtocolErrors = 5;

  net::FramedStream* stream = nullptr;
  std::uint64_t session = 0;        ///< 0 until Hello
  bool may_command = false;
  std::uint64_t last_received = 0;  ///< sequence numbers, each direction
  std::uint64_t last_sent = 0;
  int protocol_errors = 0;

  /// How long ago, at least, a message was sent: against the fastest message so far, whose delay counts as none. The
  /// peer's clock may drift by 100 ppm.
  Duration age(Time arrival, std::int64_t sent_time_ns) {
    const std::int64_t difference = to_ns(arrival) - sent_time_ns;
    if (fastest_) *fastest_ += (to_ns(arrival) - fastest_at_ns_) / 10'000;
    fastest_ = fastest_ ? std::min(*fastest_, difference) : difference;
    fastest_at_ns_ = to_ns(arrival);
    return Duration{difference - *fastest_};
  }

 private:
  std::optional<std::int64_t> fastest_;
  std::int64_t fastest_at_ns_ = 0;
};

}  // namespace armsight::arm
