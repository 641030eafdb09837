// The controller's cycle on the simulator's robot, in one process and in virtual time: no sockets, no threads, nothing
// that depends on the machine.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "arm_controller/control_loop.hpp"
#include "tools/sim/bus_model.hpp"
#include "tools/sim/world.hpp"

namespace armsight::sim {

class ClosedLoop {
 public:
  using OnFrame = std::function<void(const CanFrame& frame, Time end)>;
  explicit ClosedLoop(const RobotConfig& robot);

  /// Sees every frame of the bus at its end.
  void watch(OnFrame on_frame) { on_frame_ = std::move(on_frame); }
  void cycle();
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  bool cycle_until(const std::function<bool()>& is_true, int at_most);
  bool power_up();
  void move_to(const JointVector& q_real);

  RobotConfig robot;
  arm::ArmSnapshot state;
  std::vector<arm::Event> events;

  World& world() { return *world_; }

 private:
  class End;
  void simulate_until(Time until);

  OnFrame on_frame_;
  Time now_ = time_from_ns(1'000'000'000);
  BusModel bus_;
  std::vector<int> node_ports_;
  std::unique_ptr<World> world_;
  std::unique_ptr<arm::CanBus> end_;
  arm::Mailboxes mailboxes_;
  arm::Tape tape_;
  arm::LoopStatistics statistics_;
  std::unique_ptr<arm::ControlLoop> loop_;
};

}  // namespace armsight::sim
