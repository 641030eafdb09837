#include "tools/sim/bus_model.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace armsight::sim {

BusModel::BusModel(double bitrate_bit_s, std::size_t queue_frames)
    : bitrate_bit_s_(bitrate_bit_s), queue_frames_(queue_frames) {}

int BusModel::add_port(Deliver deliver, Order order) {
  ports_[++last_port_] = {std::move(deliver), order, {}};
  return last_port_;
}

/// A frame of its on the wire is finished: electronics do not vanish with a program.
void BusModel::remove_port(int port) { ports_.erase(port); }

bool BusModel::send(int port, const CanFrame& frame, Time now) {
  std::deque<Queued>& queue = ports_.at(port).queue;
  if (queue.size() >= queue_frames_) {
    ++dropped_;
    return false;
  }
  queue.push_back({frame, now});
  return true;
}

Duration BusModel::frame_time(const CanFrame& frame) const {
  return Duration{std::llround(1e9 * worst_case_bits(frame.size) / bitrate_bit_s_)};
}

std::deque<BusModel::Queued>::const_iterator BusModel::Port::first_at(Time time) const {
  auto first = queue.end();
  for (auto one = queue.begin(); one != queue.end() && one->time <= time; ++one) {
    if (first == queue.end() || one->frame.id < first->frame.id) first = one;
    if (order == Order::kAsQueued) break;
  }
  return first;
}

/// Starts the next frame: the bus is taken when it is free and somebody has a frame; of those that have one by then the
/// lowest identifier wins, among equals the older port.
void BusModel::arbitrate() {
  if (on_wire_) return;
  Time start = kNever;
  for (const auto& [id, port] : ports_)
    if (!port.queue.empty()) start = std::min(start, std::max(free_since_, port.queue.front().time));
  if (start == kNever) return;
  int winner = 0;
  std::deque<Queued>::const_iterator lowest;
  for (const auto& [id, port] : ports_) {
    const auto first = port.first_at(start);
    if (first == port.queue.end() || (winner != 0 && first->frame.id >= lowest->frame.id)) continue;
    winner = id;
    lowest = first;
  }
  const CanFrame frame = lowest->frame;
  ports_.at(winner).queue.erase(lowest);
  on_wire_ = Transmission{winner, frame, start + frame_time(frame)};
}

Time BusModel::next_event() {
  arbitrate();
  return on_wire_ ? on_wire_->end : kNever;
}

void BusModel::run_until(Time time) {
  while (next_event() < time) {
    const Transmission sent = *on_wire_;
    on_wire_.reset();
    free_since_ = sent.end;
    ++frames_;
    busy_ += frame_time(sent.frame);
    std::vector<int> receivers;
    for (const auto& [id, port] : ports_) receivers.push_back(id);
    for (const int id : receivers) {
      const auto port = ports_.find(id);
      if (port != ports_.end()) port->second.deliver(sent.frame, sent.end, id == sent.port);
    }
  }
}

}  // namespace armsight::sim
