#include "tools/sim/world.hpp"

#include <algorithm>
#include <numbers>

#include "tools/sim/bus_model.hpp"

namespace armsight::sim {

namespace {

/// Half an hour at 250 Hz: a simulator left running does not fill the machine.
constexpr std::size_t kMaxTraceRows = 450'000;

}  // namespace

World::World(const RobotConfig& robot, const Scene& scene, Truth truth, Time start, Send send)
    : robot_(robot), plant_(robot, scene, std::move(truth), start), before_(plant_.truth()) {
  const auto joints = static_cast<std::size_t>(robot.arm.joint_count());
  for (std::size_t i = 0; i <= joints; ++i) {
    const bool is_hand = i == joints;
    const std::uint8_t id = is_hand ? robot.hand.node : robot.drives[i].node;
    Motor& motor = is_hand ? plant_.hand_motor() : plant_.joint_motor(static_cast<int>(i));
    DriveNode::OnSample on_sample;
    if (!is_hand) on_sample = [this, i](std::int32_t counts, Time time) { sample(i, counts, time); };
    nodes_.push_back(std::make_unique<DriveNode>(
        id, [send, i](const CanFrame& frame, Time now) { send(i, frame, now); }, motor, std::move(on_sample)));
  }
}

void World::power_on(Time now) {
  for (auto& node : nodes_) node->power_on(now);
}

Time World::next_time() const {
  Time next = kNever;
  for (const auto& node : nodes_) next = std::min(next, node->next_time());
  return next;
}

void World::advance_to(Time time) {
  plant_.advance_to(time);
  for (auto& node : nodes_)
    if (node->next_time() <= time) node->on_time(time);
}

void World::on_frame(std::size_t node, const CanFrame& frame, Time time) { nodes_[node]->on_frame(frame, time); }

void World::excuse(Duration stall) {
  for (auto& node : nodes_) node->excuse(stall);
}

void World::inject_drift(Time now) {
  before_ = plant_.truth();
  plant_.inject_drift();
  drift_time_ = now;
}

void World::sample(std::size_t node, std::int32_t counts, Time time) {
  if (trace_.empty() || trace_.back().time != time) {
    if (trace_.size() >= kMaxTraceRows) {
      trace_is_cut_ = true;
      return;
    }
    const JointVector& q = plant_.q_real();
    trace_.push_back({time, q, JointVector::Zero(q.size())});
  }
  const DriveConfig& drive = robot_.drives[node];
  trace_.back().q_reading[static_cast<Eigen::Index>(node)] =
      drive.sign * 2.0 * std::numbers::pi * counts / drive.counts_per_turn + drive.zero_rad;
}

}  // namespace armsight::sim
