// A classic CAN bus in virtual time: arbitration by identifier, frame time at the bit rate, one bounded queue a sender.
// Event-driven and deterministic; who drives the time (lockstep, the machine's clock, a test) is not its business.
// Frame length is the worst case with stuffing (controller.md §3.2), about 10 % more than recorded traffic shows.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight::sim {

inline constexpr Time kNever = time_from_ns(std::numeric_limits<std::int64_t>::max());
inline constexpr std::size_t kBusQueueFrames = 32;

class BusModel {
 public:
  /// A frame's end on the wire; every port gets every frame, its sender as its own echo.
  /// What leaves a sender first: what was queued first (a socket of the kernel), or the lowest identifier of what waits
  /// (the mailboxes of a drive).
  enum class Order { kAsQueued, kByPriority };
  using Deliver = std::function<void(const CanFrame& frame, Time end, bool is_own_echo)>;

  explicit BusModel(double bitrate_bit_s, std::size_t queue_frames = kBusQueueFrames);

  int add_port(Deliver deliver, Order order = Order::kAsQueued);
  void remove_port(int port);
  /// Queues a frame; false: the queue is full, the frame is dropped.
  bool send(int port, const CanFrame& frame, Time now);

  /// End of the frame on the wire or, on an idle bus, of the next one; kNever: nothing to send.
  Time next_event();
  /// Delivers all frames that end before `time`.
  void run_until(Time time);

  Duration frame_time(const CanFrame& frame) const;
  std::uint64_t frames() const { return frames_; }
  std::uint64_t dropped() const { return dropped_; }
  Duration busy_time() const { return busy_; }

 private:
  struct Queued {
    CanFrame frame;
    Time time;
  };
  struct Port {
    Deliver deliver;
    Order order = Order::kAsQueued;
    std::deque<Queued> queue;

    /// What it would put on a bus that is free at `time`; end(): nothing.
    std::deque<Queued>::const_iterator first_at(Time time) const;
  };
  struct Transmission {
    int port;
    CanFrame frame;
    Time end;
  };
  void arbitrate();

  double bitrate_bit_s_;
  std::size_t queue_frames_;
  std::map<int, Port> ports_;
  int last_port_ = 0;
  std::optional<Transmission> on_wire_;
  Time free_since_;
  std::uint64_t frames_ = 0, dropped_ = 0;
  Duration busy_{0};
};

}  // namespace armsight::sim
