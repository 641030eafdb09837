#include "tests/faults/fault_rig.hpp"

#include <algorithm>
#include <map>
#include <numbers>

#include "tools/sim/sim_clock_server.hpp"

namespace armsight::faults {
namespace {

constexpr std::uint64_t kCommander = 7;

sim::Truth true_arm(const RobotConfig& robot, const sim::Scene& scene) {
  sim::Truth truth = sim::make_truth(robot, scene, sim::NoiseSet::kClean, sim::CameraMount::kNear, 1);
  truth.beta.setZero();  // a reading is the angle: verdicts are plain numbers
  truth.start_rad = FaultRig::posture(0.2, -0.1, -0.2, 0.8, 0.1);
  return truth;
}

}  // namespace

RobotConfig shipped_robot() { return load_robot(ARMSIGHT_HOME "/arm_controller/config/ego_right_arm.yaml"); }

FaultRig::FaultRig(const RobotConfig& config, int unpowered)
    : robot(config), bus(std::make_unique<sim::BusModel>(config.controller.bus_bitrate_bit_s)) {
  const sim::Scene scene = sim::load_scene(ARMSIGHT_HOME "/tools/sim/scene.yaml");
  world = std::make_unique<sim::World>(robot, scene, true_arm(robot, scene), now,
                                       [this](std::size_t i, const CanFrame& frame, Time time) {
                                         if (i < node_ports.size()) bus->send(node_ports[i], frame, time);
                                       });
  attach_nodes();
  bus->add_port([this](const CanFrame& frame, Time end, bool) { log.push_back({end, frame}); });
  for (int i = 1; i <= kNodes; ++i) {
    if (i == unpowered) node(i).power_off(now);
    else node(i).power_on(now);
  }
  start_controller();
}

FaultRig::~FaultRig() = default;

arm::StartModel FaultRig::start_model() const {
  arm::StartModel start{{0, robot.camera_hint_T_C_B, JointVector::Zero(kJoints)}, std::nullopt,
                        arm::ModelSource::kNominal};
  start.last_seen_rad = last_seen_rad;
  return start;
}

void FaultRig::start_controller() {
  bus_end = std::make_unique<sim::BusEnd>(*bus, now);
  loop = std::make_unique<arm::ControlLoop>(robot, start_model(), controllers_bus(), mailboxes, tape, statistics);
  state = {};
}

void FaultRig::kill_controller() {
  loop.reset();
  bus_end.reset();
  state = {};
}

void FaultRig::attach_nodes() {
  for (std::size_t i = 0; i < world->node_count(); ++i)
    node_ports.push_back(bus->add_port([this, i](const CanFrame& frame, Time end, bool is_own_echo) {
      if (is_own_echo) return;
      world->advance_to(end);
      world->on_frame(i, frame, end);
    }, sim::BusModel::Order::kByPriority));
}

/// Events in order of time: the end of a frame, or a node's timer.
void FaultRig::simulate_until(Time until) {
  for (Time next = std::min(world->next_time(), bus->next_event()); next < until;
       next = std::min(world->next_time(), bus->next_event())) {
    if (world->next_time() == next) world->advance_to(next);
    else bus->run_until(next + Duration{1});
  }
  world->advance_to(until);
}

void FaultRig::simulate(Duration span) {
  constexpr Duration kStep = std::chrono::milliseconds(1);
  for (const Time end = now + span; now < end;) {
    now = std::min(now + kStep, end);
    simulate_until(now);
    TruthRow row{now, world->plant().q_real(), {}};
    for (std::size_t i = 0; i < row.states.size(); ++i) row.states[i] = world->node(i).state();
    truth.push_back(row);
  }
}

void FaultRig::cycle(int late) {
  if (late > 0) {
    simulate(late * period());
    missed += static_cast<std::uint64_t>(late);
  }
  before_cycle();
  if (loop) loop->cycle(now, missed);
  after_cycle();
  simulate(period());
}

void FaultRig::judge_set_point() {
  const bool is_driven =
      state.mode == arm::Mode::kHold || state.mode == arm::Mode::kServo || state.mode == arm::Mode::kStopping;
  if (!is_driven) return judge_.reset();
  if (!judge_) judge_.emplace(robot.arm.limits, robot.controller.period_s);
  judge_->take(state.q_command_rad);
}

void FaultRig::after_cycle() {
  if (has_commander) mailboxes.lease.put({kCommander, now + seconds_to_duration(robot.controller.lease_s), now});
  if (const auto newest = mailboxes.state.take(); newest && loop) state = *newest;
  judge_set_point();
  arm::Event event;
  while (mailboxes.events.pop(event)) events.push_back(event);
  while (tape.events.pop(event)) {
  }
  arm::TickRecord record;
  arm::OrdersRecord orders;
  while (tape.ticks.pop(record)) {
  }
  while (tape.orders.pop(orders)) {
  }
  tape.checkpoints.take([](std::uint64_t, std::span<const std::byte>) {});
}

bool FaultRig::cycle_until(const std::function<bool()>& is_true, int at_most) {
  for (int i = 0; i < at_most && !is_true(); ++i) cycle();
  return is_true();
}

bool FaultRig::power_up() {
  if (!cycle_until([this] { return is_configured(); }, 2000)) return false;
  order_mode(arm::PowerWish::kHold);
  const auto is_up = [this] { return state.mode == arm::Mode::kHold && all_drives(DriveState::kOperationEnabled); };
  return cycle_until(is_up, 500);
}

bool FaultRig::start_moving() {
  if (!power_up()) return false;
  send_goal(far_goal());
  cycles(125);
  return fastest_rad_s() > 0.4;
}

void FaultRig::order_mode(arm::PowerWish wish, bool clear_fault) {
  mailboxes.mode.put({{kCommander, ++sequence_}, wish, clear_fault});
}

void FaultRig::send_goal(const JointVector& q_real_rad, double speed_scale) {
  arm::Goal goal;
  goal.tag = {kCommander, ++sequence_};
  goal.id = sequence_;
  goal.q_real_rad = q_real_rad;
  goal.speed_scale = speed_scale;
  mailboxes.goal.put(goal);
}

JointVector FaultRig::posture(double q1, double q2, double q3, double q4, double q5) {
  JointVector q(kJoints);
  q << q1, q2, q3, q4, q5;
  return q;
}

double FaultRig::fastest_rad_s() const {
  double fastest = 0.0;
  for (int i = 0; i < kJoints; ++i) fastest = std::max(fastest, std::abs(world->plant().speed_rad_s(i)));
  return fastest;
}

bool FaultRig::all_drives(DriveState wanted) const {
  for (int node = 1; node <= kNodes; ++node)
    if (drive(node) != wanted) return false;
  return true;
}

bool FaultRig::no_drive(DriveState unwanted) const {
  for (int node = 1; node <= kNodes; ++node)
    if (drive(node) == unwanted) return false;
  return true;
}

std::optional<Time> FaultRig::left(int node, DriveState which, Time since) const {
  for (const TruthRow& row : truth)
    if (row.time > since && row.states[index(node)] != which) return row.time;
  return std::nullopt;
}

double FaultRig::travelled_rad(Time since) const {
  const auto first = std::ranges::find_if(truth, [since](const TruthRow& row) { return row.time >= since; });
  double farthest = 0.0;
  for (auto row = first; row != truth.end(); ++row)
    farthest = std::max(farthest, (row->q_rad - first->q_rad).cwiseAbs().maxCoeff());
  return farthest;
}

int FaultRig::count(Time since, const std::function<bool(const CanFrame&)>& is_it) const {
  return static_cast<int>(
      std::ranges::count_if(log, [&](const BusLine& line) { return line.time > since && is_it(line.frame); }));
}

double FaultRig::largest_step_rad(Time since) const {
  std::map<std::uint32_t, std::int32_t> last;
  double largest = 0.0;
  for (const BusLine& line : log) {
    if (line.time <= since) continue;
    for (std::uint8_t i = 1; i <= kJoints; ++i) {
      const auto command = decode_rpdo1(line.frame, i);
      if (!command) continue;
      const bool is_enabling = (command->controlword & 0x0F) == kEnableOperation;
      if (is_enabling && last.contains(i))
        largest = std::max(largest, 2.0 * std::numbers::pi * std::abs(command->target_counts - last[i]) / 32768.0);
      if (is_enabling) last[i] = command->target_counts;
      else last.erase(i);
    }
  }
  return largest;
}

}  // namespace armsight::faults
