#include "tools/sim/bus_model.hpp"

#include <algorithm>
#include <cmath>

namespace armsight::sim {

namespace {

constexpr int kErrorFrameBits = 31;       // two flags, delimiter, intermission: the longest (controller.md §3.2)
constexpr int kRecoveryBits = 128 * 11;
constexpr int kTransmitError = 8, kReceiveError = 1, kSuccess = -1;
constexpr int kPassiveAbove = 127, kOffAbove = 255;

}  // namespace

BusModel::BusModel(const BusRates& rates, std::size_t queue_frames) : rates_(rates), queue_frames_(queue_frames) {}

int BusModel::add_port(Deliver deliver, Order order, OnState on_state) {
  Port& port = ports_[++last_port_];
  port.deliver = std::move(deliver);
  port.order = order;
  port.on_state = std::move(on_state);
  return last_port_;
}

/// A frame of its on the wire is finished: electronics do not vanish with a program.
void BusModel::remove_port(int port) { ports_.erase(port); }

bool BusModel::send(int port, const CanFrame& frame, Time now) {
  Port& sender = ports_.at(port);
  if (sender.queue.size() >= queue_frames_ || sender.state == PortState::kBusOff) {
    ++dropped_;
    return false;
  }
  sender.queue.push_back({frame, now});
  const int missing = kPassiveAbove + 1 - sender.transmit_errors;  // sixteen tries, within 3 ms
  if (!sender.is_connected && missing > 0) count(sender, sender.transmit_errors, missing, now);
  return true;
}

Duration BusModel::bits(int count) const { return Duration{std::llround(1e9 * count / rates_.bitrate_bit_s)}; }
Duration BusModel::frame_time(const CanFrame& frame) const {
  return Duration{std::llround(1e9 * worst_case_s(frame.size, frame.is_fd, rates_))};
}

std::deque<BusModel::Queued>::iterator BusModel::Port::first_at(Time time) {
  auto first = queue.end();
  for (auto one = queue.begin(); one != queue.end() && one->time <= time; ++one) {
    if (first == queue.end() || one->frame.id < first->frame.id) first = one;
    if (order == Order::kAsQueued) break;
  }
  return first;
}

/// Starts the next frame: the bus is taken when it is free and somebody has a frame; of those that have one by then the
/// lowest identifier wins. Senders of the same identifier both go on: the same frame is one, different ones collide.
void BusModel::arbitrate() {
  if (on_wire_) return;
  Time start = kNever;
  for (const auto& [id, port] : ports_)
    if (can_send(port)) start = std::min(start, std::max(free_since_, port.queue.front().time));
  if (start == kNever) return;
  Transmission next;
  for (auto& [id, port] : ports_) {
    const auto first = can_send(port) ? port.first_at(start) : port.queue.end();
    if (first == port.queue.end()) continue;
    const CanFrame frame = first->frame;
    std::rotate(port.queue.begin(), first, first + 1);  // what is on the wire stands first
    if (next.senders.empty() || frame.id < next.frame.id) {
      next = {{id}, frame, {}, false};
    } else if (frame.id == next.frame.id) {
      next.is_collision = next.is_collision || frame != next.frame;
      next.senders.push_back(id);
    }
  }
  next.end = start + frame_time(next.frame);
  on_wire_ = next;
}

Time BusModel::next_restart() const {
  Time next = kNever;
  for (const auto& [id, port] : ports_) next = std::min(next, port.restart);
  return next;
}

Time BusModel::next_event() {
  arbitrate();
  const Time late = late_.empty() ? kNever : late_.begin()->first;
  return std::min({on_wire_ ? on_wire_->end : kNever, late, next_restart()});
}

void BusModel::run_until(Time time) {
  for (Time event = next_event(); event < time; event = next_event()) {
    if (next_restart() == event) {
      restart_ports(event);
    } else if (!late_.empty() && late_.begin()->first == event) {
      const Late late = late_.begin()->second;
      late_.erase(late_.begin());
      deliver(late.frame, late.senders, event, false, true);
    } else {
      const Transmission sent = *on_wire_;
      on_wire_.reset();
      finish(sent);
    }
  }
}

bool BusModel::is_acknowledged(const Transmission& sent) const {
  return std::ranges::any_of(
      ports_, [&](const auto& port) { return is_on_bus(port.second) && !sent.is_of(port.first); });
}

void BusModel::finish(const Transmission& sent) {
  busy_ += frame_time(sent.frame);
  free_since_ = sent.end;
  const bool is_heard = is_acknowledged(sent);
  const Passage passage = judge_ && !sent.is_collision ? judge_(sent.frame, sent.end) : Passage{};
  if (!is_heard || sent.is_collision || passage.is_destroyed) return destroy(sent, is_heard);
  ++frames_;
  for (auto& [id, port] : ports_) {
    if (sent.is_of(id)) port.queue.pop_front();
    if (sent.is_of(id)) count(port, port.transmit_errors, kSuccess, sent.end);
    else if (is_on_bus(port)) count(port, port.receive_errors, kSuccess, sent.end);
  }
  deliver(sent.frame, sent.senders, sent.end, true, false);
  if (passage.is_lost) return;
  const CanFrame heard = passage.altered.value_or(sent.frame);
  if (passage.delay > Duration::zero()) late_.insert({sent.end + passage.delay, {heard, sent.senders}});
  else deliver(heard, sent.senders, sent.end, false, true);
  if (passage.comes_twice) late_.insert({sent.end + passage.delay + frame_time(heard), {heard, sent.senders}});
}

/// The frame stays at the head of its sender's queue. Without an acknowledgement an error-passive sender counts no
/// further: a node alone on its bus never goes bus-off.
void BusModel::destroy(const Transmission& sent, bool is_heard) {
  ++error_frames_;
  free_since_ = sent.end + bits(kErrorFrameBits);
  busy_ += bits(kErrorFrameBits);
  for (auto& [id, port] : ports_) {
    if (!is_on_bus(port)) continue;
    const bool counts = is_heard || port.state == PortState::kErrorActive;
    if (!sent.is_of(id)) count(port, port.receive_errors, kReceiveError, sent.end);
    else if (counts) count(port, port.transmit_errors, kTransmitError, sent.end);
  }
}

void BusModel::count(Port& port, int& counter, int change, Time now) {
  counter = std::max(0, counter + change);
  if (port.transmit_errors > kOffAbove) return go_off(port, now);
  const bool is_passive = port.transmit_errors > kPassiveAbove || port.receive_errors > kPassiveAbove;
  const PortState state = is_passive ? PortState::kErrorPassive : PortState::kErrorActive;
  if (state == port.state || port.state == PortState::kBusOff) return;
  port.state = state;
  if (port.on_state) port.on_state(state, now);
}

void BusModel::go_off(Port& port, Time now) {
  if (port.state == PortState::kBusOff) return;
  port.state = PortState::kBusOff;
  port.queue.clear();
  port.restart = now + kBusRestartAfter + bits(kRecoveryBits);
  if (on_wire_) on_wire_.reset();  // starts again without it
  if (port.on_state) port.on_state(port.state, now);
}

void BusModel::restart_ports(Time now) {
  for (auto& [id, port] : ports_) {
    if (port.restart > now) continue;
    port.restart = kNever;
    port.transmit_errors = port.receive_errors = 0;
    port.state = PortState::kErrorActive;
    if (port.on_state) port.on_state(port.state, now);
  }
}

/// A port that a delivery adds or removes does not disturb the round.
void BusModel::deliver(const CanFrame& frame, const std::vector<int>& senders, Time time, bool to_senders,
                       bool to_others) {
  std::vector<int> receivers;
  for (const auto& [id, port] : ports_) receivers.push_back(id);
  for (const int id : receivers) {
    const auto port = ports_.find(id);
    if (port == ports_.end() || !is_on_bus(port->second)) continue;
    const bool is_sender = std::ranges::find(senders, id) != senders.end();
    if (is_sender ? to_senders : to_others) port->second.deliver(frame, time, is_sender);
  }
}

}  // namespace armsight::sim
