// Plays one recorded host against a fresh controller on the same simulated clock, and compares its answers.
//
// Same seed and same place in the order of joining give the same crystal, so the clock here shows in every cycle what
// the recorded host's showed: each message goes out when now() is its sent_time_ns, and acts in the recorded cycle.
// Only the session is new, which the controller chooses by itself.
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "protocol/transport/framed_stream.hpp"
#include "tools/replay/envelope_fields.hpp"
#include "tools/replay/link_file.hpp"

namespace armsight::replay {

/// This recording cannot be played on this clock or to this controller; what() says why: exit code 2.
class NotReplayable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Difference {
  std::int64_t arm_time_ns = 0;            ///< of the recorded message, the controller's clock
  FieldDifference what;
};

struct PlayResult {
  std::size_t sent = 0, compared = 0;
  std::optional<Difference> difference;    ///< the first; the player left there
};

/// Throws NotReplayable where that shows without playing: real pace, no Hello, another place in the order of joining.
void check_replayable(const Connection& recorded, const net::Clock& clock);

class LinkPlayer {
 public:
  LinkPlayer(const Connection& recorded, std::string arm_address, net::Clock& clock);
  /// Returns in the cycle after the last recorded message. Throws NotReplayable, net::ClockLost, and
  /// std::runtime_error when the controller cannot be reached.
  PlayResult play();

 private:
  void wait_for_hello();
  void send_due();
  void receive();
  void compare(const wire::Envelope& replayed);
  void take_session(const wire::Envelope& replayed);
  void report_missing(const std::string& instead);
  bool is_over() const;

  const Connection& recorded_;
  std::size_t expected_;                   ///< how many messages of the controller come again
  std::string arm_address_;
  net::Clock& clock_;
  std::unique_ptr<net::FramedStream> stream_;
  std::uint64_t session_ = 0;
  int silent_cycles_ = 0;
  PlayResult result_;
};

}  // namespace armsight::replay
