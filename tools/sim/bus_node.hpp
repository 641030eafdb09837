// Whatever sits on the robot's bus: given frames and time, it answers through a function.
#pragma once

#include <functional>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight::sim {

using SendFrame = std::function<void(const CanFrame& frame, Time now)>;

class BusNode {
 public:
  BusNode() = default;
  virtual ~BusNode() = default;
  BusNode(const BusNode&) = delete;
  BusNode& operator=(const BusNode&) = delete;

  virtual void power_on(Time now) = 0;
  virtual void on_frame(const CanFrame& frame, Time now) = 0;
  /// Timers; to be called at next_time() or later.
  virtual void on_time(Time now) = 0;
  virtual Time next_time() const = 0;
  /// Nothing could be heard for so long because the simulator itself did not run: that is no silence of others.
  virtual void excuse(Duration stall) = 0;
};

}  // namespace armsight::sim
