// The controller's cycle on the simulator's robot, in one process and in virtual time: no sockets, no threads, nothing
// that depends on the machine.
#pragma once

#include <array>
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
  using OnFrame = std::function<void(std::size_t bus, const CanFrame& frame, Time end)>;
  /// last_seen: readings of an earlier run.
  explicit ClosedLoop(const RobotConfig& robot, const std::optional<JointVector>& last_seen = std::nullopt);

  /// Sees every frame of every bus at its end.
  void watch(OnFrame on_frame) { on_frame_ = std::move(on_frame); }
  void cycle();
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  bool cycle_until(const std::function<bool()>& is_true, int at_most);
  bool power_up();
  void move_to(const JointVector& q_real);
  void soften(const std::array<std::uint16_t, kMaxJoints>& permille);
  void order(arm::PowerWish wish, bool clear_fault = false);
  /// Time goes on without the controller.
  void die_for(Duration duration);
  /// The controller's interface to that bus is pulled: nothing comes, nothing goes, and it is told so.
  void cut(std::size_t bus) { is_cut_[bus] = true; }

  RobotConfig robot;
  arm::ArmSnapshot state;
  std::vector<arm::Event> events;
  std::optional<arm::SelfCheck> self_check;  ///< the newest

  /// Nothing finds room there any more.
  void fill(std::size_t bus) { is_full_[bus] = true; }
  World& world() { return *world_; }
  /// What the encoders showed at the newest SYNC.
  const JointVector& encoders() const { return world_->trace().back().q_reading; }
  const arm::ControlLoop& loop() const { return *loop_; }

 private:
  class End;
  void simulate_until(Time until);

  OnFrame on_frame_;
  Time now_ = time_from_ns(1'000'000'000);
  std::deque<BusModel> buses_;
  std::array<bool, kMaxBuses> is_cut_{}, is_full_{};
  std::vector<std::size_t> bus_of_node_;
  std::vector<int> node_ports_;
  std::unique_ptr<World> world_;
  std::unique_ptr<arm::CanBus> ends_;
  arm::Mailboxes mailboxes_;
  arm::Tape tape_;
  arm::LoopStatistics statistics_;
  std::unique_ptr<arm::ControlLoop> loop_;
};

}  // namespace armsight::sim
