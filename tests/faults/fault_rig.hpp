// The controller's real cycle against the simulated robot on the bus model, all in virtual time and in one thread; a
// test breaks something and reads its verdict from what the simulator knows: positions, drive states, its bus.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "arm_controller/control_loop.hpp"
#include "tests/shared/setpoint_judge.hpp"
#include "tools/sim/in_process_bus.hpp"
#include "tools/sim/world.hpp"

namespace armsight::faults {

inline constexpr int kJoints = 5, kNodes = 6;
inline constexpr double kCount_rad = 2.0 * std::numbers::pi / 32768.0;  ///< of an encoder

/// The shipped robot file.
RobotConfig shipped_robot();

/// What was true, once a millisecond.
struct TruthRow {
  Time time;
  JointVector q_rad;                          ///< real angles; the rig's encoders have no offset
  std::array<DriveState, kNodes> states;
};

/// A frame that ended on the bus.
struct BusLine {
  Time time;
  CanFrame frame;
};

class FaultRig {
 public:
  /// Node `unpowered` has no power yet; 0: all have.
  explicit FaultRig(const RobotConfig& robot = shipped_robot(), int unpowered = 0);
  virtual ~FaultRig();

  /// Starts when the rig is built; again after kill_controller().
  void start_controller();
  /// SIGKILL: nothing is said, its queue is gone.
  void kill_controller();

  /// One period; `late` periods later than due.
  void cycle(int late = 0);
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  bool cycle_until(const std::function<bool()>& is_true, int at_most);

  bool is_configured() const { return state.mode == arm::Mode::kReady; }
  /// From anywhere to six enabled drives; by truth.
  bool power_up();
  /// ... and half a second into a long move at 0.5 rad/s.
  bool start_moving();
  void order_mode(arm::PowerWish wish, bool clear_fault = false);
  void send_goal(const JointVector& q_real_rad, double speed_scale = 1.0);
  static JointVector posture(double q1, double q2, double q3, double q4, double q5);
  static JointVector far_goal() { return posture(1.3, 0.6, -1.3, 2.1, 1.2); }

  // Truth.
  const JointVector& q_rad() const { return world->plant().q_real(); }
  double fastest_rad_s() const;
  /// A joint that a drive leads comes to its target ever more slowly.
  bool is_still() const { return fastest_rad_s() < 1e-3; }
  DriveState drive(int node) const { return world->node(index(node)).state(); }
  bool all_drives(DriveState state) const;
  bool no_drive(DriveState state) const;
  sim::DriveNode& node(int number) { return world->node(index(number)); }
  int node_port(int node) const { return node_ports.at(index(node)); }
  int controller_port() const { return bus_end->port(); }
  /// When this drive was first seen outside a state, after `since`; nullopt: it still is in it.
  std::optional<Time> left(int node, DriveState state, Time since) const;
  /// Farthest that any joint has been from where it was then.
  double travelled_rad(Time since) const;
  /// Frames after `since` of which this is true.
  int count(Time since, const std::function<bool(const CanFrame&)>& is_it) const;
  /// Largest step between two set-points of the same drive under "enable operation", in rad.
  double largest_step_rad(Time since) const;
  /// Fault that the controller names: beside a verdict, never instead of one.
  arm::FaultCode named() const { return state.fault.code; }

  RobotConfig robot;
  std::unique_ptr<sim::BusModel> bus;
  std::unique_ptr<sim::World> world;
  std::vector<int> node_ports;
  Time now = time_from_ns(10'000'000'000);
  std::vector<TruthRow> truth;
  std::vector<BusLine> log;

  bool has_commander = true;      ///< else nobody renews the lease
  std::uint64_t missed = 0;
  std::optional<JointVector> last_seen_rad;   ///< what a controller that starts is told
  std::unique_ptr<sim::BusEnd> bus_end;
  arm::Mailboxes mailboxes;
  arm::Tape tape;
  arm::LoopStatistics statistics;
  std::unique_ptr<arm::ControlLoop> loop;
  arm::ArmSnapshot state;
  std::vector<arm::Event> events;

  template <typename E>
  const E* last() const {
    for (auto it = events.rbegin(); it != events.rend(); ++it)
      if (const E* e = std::get_if<E>(&*it)) return e;
    return nullptr;
  }
  Duration period() const { return seconds_to_duration(robot.controller.period_s); }

 protected:
  virtual arm::StartModel start_model() const;
  virtual void before_cycle() {}
  /// Takes what the cycle left in mailboxes and tape.
  virtual void after_cycle();
  /// The invariant of every test here: no set-point beyond a limit of position, speed, acceleration or jerk.
  void judge_set_point();
  /// Where the cycle's frames go and come from.
  virtual arm::CanBus& controllers_bus() { return *bus_end; }

 private:
  static std::size_t index(int node) { return static_cast<std::size_t>(node - 1); }
  void attach_nodes();
  void simulate(Duration span);
  void simulate_until(Time until);
  std::uint64_t sequence_ = 0;
  std::optional<test::SetpointJudge> judge_;
};

}  // namespace armsight::faults
