// A bus without sockets for unit tests: CanBus ends on a BusModel, in virtual time.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "arm_controller/can_bus.hpp"
#include "tools/sim/bus_model.hpp"

namespace armsight::sim {

/// A program's end on a bus model whose time somebody else drives. Model and time must outlive it.
class BusEnd : public arm::CanBus {
 public:
  BusEnd(BusModel& model, const Time& now) : model_(model), now_(now) {
    port_ = model_.add_port(
        [this](const CanFrame& frame, Time end, bool is_own_echo) { inbox_.push_back({frame, end, is_own_echo}); },
        BusModel::Order::kAsQueued,
        [this](PortState state, Time) {
          if (state == PortState::kBusOff) errors_.bus_off = true;
          if (state == PortState::kErrorPassive) errors_.error_passive = true;
        });
  }
  ~BusEnd() override { model_.remove_port(port_); }
  BusEnd(const BusEnd&) = delete;
  BusEnd& operator=(const BusEnd&) = delete;
  int port() const { return port_; }

  arm::SendResult send(const CanFrame& frame) noexcept override {
    if (model_.send(port_, frame, now_)) return arm::SendResult::kSent;
    ++errors_.send_failures;
    return arm::SendResult::kQueueFull;
  }
  bool receive(arm::BusFrame& frame) noexcept override {
    if (inbox_.empty()) return false;
    frame = inbox_.front();
    inbox_.pop_front();
    return true;
  }
  arm::BusErrors take_errors() noexcept override { return std::exchange(errors_, {}); }
  const std::string& name() const override { return name_; }

 private:
  BusModel& model_;
  const Time& now_;
  int port_;
  std::deque<arm::BusFrame> inbox_;
  arm::BusErrors errors_;
  std::string name_ = "in-process";
};

class InProcessBus {
 public:
  explicit InProcessBus(double bitrate_bit_s = 1e6, std::size_t queue_frames = kBusQueueFrames)
      : model_(bitrate_bit_s, queue_frames) {}

  /// A program's end. The bus must outlive it.
  std::unique_ptr<arm::CanBus> join() { return std::make_unique<BusEnd>(model_, now_); }
  BusModel& model() { return model_; }
  Time now() const { return now_; }
  void advance_to(Time time) {
    model_.run_until(time);
    now_ = time;
  }

 private:
  BusModel model_;
  Time now_;
};

}  // namespace armsight::sim
