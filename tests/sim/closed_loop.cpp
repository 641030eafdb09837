#include "tests/sim/closed_loop.hpp"

#include <algorithm>
#include <utility>

#include "arm_controller/several_buses.hpp"

namespace armsight::sim {

/// The controller's end of a bus.
class ClosedLoop::End final : public arm::CanBus {
 public:
  End(ClosedLoop& loop, std::size_t number) : loop_(loop), number_(number), bus_(loop.buses_[number]) {
    port_ = bus_.add_port([this](const CanFrame& frame, Time end, bool is_own_echo) {
      if (!loop_.is_cut_[number_]) inbox_.push_back({frame, end, is_own_echo});
      if (loop_.on_frame_) loop_.on_frame_(number_, frame, end);
    });
  }
  arm::SendResult send(const CanFrame& frame) noexcept override {
    if (loop_.is_cut_[number_]) return arm::SendResult::kBusDown;
    if (loop_.is_full_[number_]) return arm::SendResult::kQueueFull;
    return bus_.send(port_, frame, loop_.now_) ? arm::SendResult::kSent : arm::SendResult::kQueueFull;
  }
  bool receive(arm::BusFrame& frame) noexcept override {
    if (inbox_.empty()) return false;
    frame = inbox_.front();
    inbox_.pop_front();
    return true;
  }
  arm::BusErrors take_errors() noexcept override {
    arm::BusErrors errors;
    errors.lost = loop_.is_cut_[number_];
    return errors;
  }
  const std::string& name() const override { return name_; }

 private:
  ClosedLoop& loop_;
  std::size_t number_;
  BusModel& bus_;
  int port_;
  std::deque<arm::BusFrame> inbox_;
  std::string name_ = "in-process";
};

ClosedLoop::ClosedLoop(const RobotConfig& config, const std::optional<JointVector>& last_seen) : robot(config) {
  for (int i = 0; i < robot.bus_count(); ++i) buses_.emplace_back(bus_rates(robot));
  for (const DriveConfig& drive : robot.drives) bus_of_node_.push_back(drive.bus);
  bus_of_node_.push_back(robot.hand.bus);
  const Scene scene = load_scene(ARMSIGHT_SOURCE_DIR "/tools/sim/scene.yaml");
  const auto send = [this](std::size_t node, const CanFrame& frame, Time now) {
    buses_[bus_of_node_[node]].send(node_ports_[node], frame, now);
  };
  const Truth truth = make_truth(robot, scene, NoiseSet::kClean, CameraMount::kNear, 1);
  world_ = std::make_unique<World>(robot, scene, truth, now_, send);
  for (std::size_t i = 0; i < world_->node_count(); ++i)
    node_ports_.push_back(buses_[bus_of_node_[i]].add_port([this, i](const CanFrame& frame, Time end, bool is_own) {
      if (is_own) return;
      world_->advance_to(end);
      world_->on_frame(i, frame, end);
    }, BusModel::Order::kByPriority));
  std::vector<std::unique_ptr<arm::CanBus>> ends;
  for (std::size_t i = 0; i < buses_.size(); ++i) ends.push_back(std::make_unique<End>(*this, i));
  ends_ = arm::join_buses(std::move(ends));
  const JointVector zero = JointVector::Zero(robot.arm.joint_count());
  const arm::StartModel start{{0, robot.camera_hint_T_C_B, zero}, std::nullopt, arm::ModelSource::kNominal, last_seen};
  loop_ = std::make_unique<arm::ControlLoop>(robot, start, *ends_, mailboxes_, tape_, statistics_);
  world_->power_on(now_);
}

void ClosedLoop::simulate_until(Time until) {
  while (true) {
    const Time timer = world_->next_time();
    Time frame = kNever;
    for (BusModel& bus : buses_) frame = std::min(frame, bus.next_event());
    if (std::min(timer, frame) >= until) break;
    if (timer <= frame) world_->advance_to(timer);
    else
      for (BusModel& bus : buses_) bus.run_until(frame + Duration{1});
  }
  world_->advance_to(until);
}

void ClosedLoop::cycle() {
  const Time next = now_ + seconds_to_duration(robot.controller.period_s);
  simulate_until(next);
  now_ = next;
  mailboxes_.lease.put({1, now_ + seconds_to_duration(robot.controller.lease_s)});
  loop_->cycle(now_, 0);
  if (const auto newest = mailboxes_.state.take()) state = *newest;
  for (arm::Event event; mailboxes_.events.pop(event);) events.push_back(event);
  if (const auto check = mailboxes_.self_check.take()) self_check = *check;
  for (arm::Event event; tape_.events.pop(event);) continue;
  for (arm::TickRecord record; tape_.ticks.pop(record);) continue;
  for (arm::OrdersRecord orders; tape_.orders.pop(orders);) continue;
  tape_.checkpoints.take([](std::uint64_t, std::span<const std::byte>) {});
}

bool ClosedLoop::cycle_until(const std::function<bool()>& is_true, int at_most) {
  for (int i = 0; i < at_most && !is_true(); ++i) cycle();
  return is_true();
}

bool ClosedLoop::power_up() {
  if (!cycle_until([&] { return state.mode == arm::Mode::kReady; }, 2000)) return false;
  order(arm::PowerWish::kHold);
  return cycle_until([&] { return state.mode == arm::Mode::kHold; }, 2000);
}

void ClosedLoop::soften(const std::array<std::uint16_t, kMaxJoints>& permille) {
  mailboxes_.stiffness.put({{1, 1}, permille});
}

void ClosedLoop::order(arm::PowerWish wish, bool clear_fault) { mailboxes_.mode.put({{1, 1}, wish, clear_fault}); }

void ClosedLoop::die_for(Duration duration) {
  now_ += duration;
  simulate_until(now_);
}

void ClosedLoop::move_to(const JointVector& q_real) {
  arm::Goal goal;
  goal.tag = {1, 1};
  goal.id = 1;
  goal.q_real_rad = q_real;
  mailboxes_.goal.put(goal);
}

}  // namespace armsight::sim
