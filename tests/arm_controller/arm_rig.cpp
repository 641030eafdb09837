#include "tests/arm_controller/arm_rig.hpp"

#include <cmath>
#include <numbers>

namespace armsight::arm::test {

ArmRig::ArmRig(const RobotConfig& config) : robot(config), bus(std::vector<double>(6, 32768.0)) {
  const std::array<double, 5> q{0.2, -0.1, -0.2, 0.8, 0.1};
  for (int i = 0; i < 5; ++i)
    bus.drive(i + 1).position_counts = q[static_cast<std::size_t>(i)] / (2.0 * std::numbers::pi) * 32768.0;
  loop = std::make_unique<ControlLoop>(robot, nominal_start(robot), bus, mailboxes, tape, statistics);
}

void ArmRig::cycle() {
  now += seconds_to_duration(robot.controller.period_s);
  bus.now = now;
  if (has_commander) mailboxes.lease.put({commander, now + seconds_to_duration(robot.controller.lease_s)});
  loop->cycle(now, missed);
  if (const auto newest = mailboxes.state.take()) state = *newest;
  Event event;
  while (mailboxes.events.pop(event)) events.push_back(event);
  while (tape.events.pop(event)) {
  }
  tape.checkpoints.take(
      [this](std::uint64_t done, std::span<const std::byte> bytes) { box.keep_checkpoint(done, bytes); });
  TickRecord record;
  OrdersRecord orders;
  while (tape.ticks.pop(record)) {
    while (tape.orders.pop(orders)) box.keep(orders);
    box.keep(record);
  }
}

bool ArmRig::cycle_until(const std::function<bool()>& is_true, int at_most) {
  for (int i = 0; i < at_most && !is_true(); ++i) cycle();
  return is_true();
}

bool ArmRig::bring_to(Mode mode, int at_most) {
  return cycle_until([&] { return state.mode == mode; }, at_most);
}

bool ArmRig::power_up() {
  if (!bring_to(Mode::kReady)) return false;
  order_mode(PowerWish::kHold);
  return bring_to(Mode::kHold);
}

void ArmRig::order_mode(PowerWish wish, bool clear_fault) { mailboxes.mode.put({{7, 1}, wish, clear_fault}); }

Goal ArmRig::joint_goal(std::uint64_t id, const JointVector& q_real) const {
  Goal goal;
  goal.tag = {7, id};
  goal.id = id;
  goal.q_real_rad = q_real;
  return goal;
}

}  // namespace armsight::arm::test
