// A CAN bus in virtual time, classic and FD frames mixed: arbitration by identifier, frame time at the bit rates, one
// bounded queue a sender, acknowledgement, and the fault confinement of ISO 11898-1: error counters, error passive,
// bus-off.
// Event-driven and deterministic; who drives the time (lockstep, the machine's clock, a test) is not its business.
// Frame length is the worst case with stuffing (controller.md §3.2), about 10 % more than recorded traffic shows.
//
//   transmit errors + 8, receive errors + 1, good frames − 1:
//   error active ──above 127──► error passive ──transmit errors above 255──► bus-off (queue lost)
//        ▲                                                                      │ kBusRestartAfter, 128 × 11 bits
//        └──────────────────────────────────────────────────────────────────────┘
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight::sim {

inline constexpr Time kNever = time_from_ns(std::numeric_limits<std::int64_t>::max());
inline constexpr std::size_t kBusQueueFrames = 32;
inline constexpr Duration kBusRestartAfter = std::chrono::milliseconds(100);  ///< SocketCAN's restart-ms

enum class PortState : std::uint8_t { kErrorActive, kErrorPassive, kBusOff };

/// What becomes of a frame on the wire; see BusModel::set_judge.
struct Passage {
  bool is_destroyed = false;        ///< a bit error: an error frame follows, and the sender tries again
  // What a bus never does, and a gateway or a bad driver does: the sender is told that all is well.
  bool is_lost = false;             ///< nobody else hears it
  bool comes_twice = false;
  Duration delay{0};                ///< heard so much later
  std::optional<CanFrame> altered{};  ///< heard so instead, with a good checksum
};

class BusModel {
 public:
  /// What leaves a sender first: what was queued first (a socket of the kernel), or the lowest identifier of what waits
  /// (the mailboxes of a drive).
  enum class Order { kAsQueued, kByPriority };
  /// A frame's end on the wire; every port gets every frame, its sender as its own echo.
  using Deliver = std::function<void(const CanFrame& frame, Time end, bool is_own_echo)>;
  using OnState = std::function<void(PortState state, Time time)>;
  using Judge = std::function<Passage(const CanFrame& frame, Time end)>;

  explicit BusModel(const BusRates& rates, std::size_t queue_frames = kBusQueueFrames);
  explicit BusModel(double bitrate_bit_s, std::size_t queue_frames = kBusQueueFrames)
      : BusModel(BusRates{bitrate_bit_s}, queue_frames) {}

  int add_port(Deliver deliver, Order order = Order::kAsQueued, OnState on_state = {});
  void remove_port(int port);
  /// Queues a frame; false: the queue is full or the port is bus-off, the frame is dropped.
  bool send(int port, const CanFrame& frame, Time now);

  /// End of the frame on the wire or, on an idle bus, of the next one; kNever: nothing to send.
  Time next_event();
  /// Delivers all frames that end before `time`.
  void run_until(Time time);

  /// Asked about every frame; none: all pass.
  void set_judge(Judge judge) { judge_ = std::move(judge); }
  /// The cable of a port. Without it nobody acknowledges its frames: it becomes error passive, and what its queue holds
  /// by then goes out when the cable is back.
  void set_connected(int port, bool is_connected) { ports_.at(port).is_connected = is_connected; }
  /// As after 32 transmit errors in a row.
  void force_bus_off(int port, Time now) { go_off(ports_.at(port), now); }
  PortState state(int port) const { return ports_.at(port).state; }
  int transmit_errors(int port) const { return ports_.at(port).transmit_errors; }
  int receive_errors(int port) const { return ports_.at(port).receive_errors; }

  Duration frame_time(const CanFrame& frame) const;
  std::uint64_t frames() const { return frames_; }
  std::uint64_t dropped() const { return dropped_; }
  std::uint64_t error_frames() const { return error_frames_; }
  Duration busy_time() const { return busy_; }

 private:
  struct Queued {
    CanFrame frame;
    Time time;
  };
  struct Port {
    Deliver deliver;
    OnState on_state;
    Order order = Order::kAsQueued;
    std::deque<Queued> queue;
    bool is_connected = true;
    PortState state = PortState::kErrorActive;
    int transmit_errors = 0, receive_errors = 0;
    Time restart = kNever;  ///< bus-off until then

    /// What it would put on a bus that is free at `time`; end(): nothing.
    std::deque<Queued>::iterator first_at(Time time);
  };
  struct Transmission {
    std::vector<int> senders;  ///< more than one: the same frame, bit by bit
    CanFrame frame;
    Time end;
    bool is_collision = false;  ///< two senders, one identifier, different data
    bool is_of(int port) const { return std::ranges::find(senders, port) != senders.end(); }
  };
  struct Late {
    CanFrame frame;
    std::vector<int> senders;
  };
  static bool is_on_bus(const Port& port) { return port.is_connected && port.state != PortState::kBusOff; }
  static bool can_send(const Port& port) { return is_on_bus(port) && !port.queue.empty(); }
  bool is_acknowledged(const Transmission& sent) const;
  Duration bits(int count) const;
  void arbitrate();
  void finish(const Transmission& sent);
  void destroy(const Transmission& sent, bool is_heard);
  void deliver(const CanFrame& frame, const std::vector<int>& senders, Time time, bool to_senders, bool to_others);
  void count(Port& port, int& counter, int change, Time now);
  void go_off(Port& port, Time now);
  void restart_ports(Time now);
  Time next_restart() const;

  BusRates rates_;
  std::size_t queue_frames_;
  Judge judge_;
  std::map<int, Port> ports_;
  int last_port_ = 0;
  std::optional<Transmission> on_wire_;
  std::multimap<Time, Late> late_;
  Time free_since_;
  std::uint64_t frames_ = 0, dropped_ = 0, error_frames_ = 0;
  Duration busy_{0};
};

}  // namespace armsight::sim
