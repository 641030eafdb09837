#include "tools/sim/world.hpp"

#include <algorithm>
#include <numbers>

#include "tools/sim/bus_model.hpp"

namespace armsight::sim {

namespace {

/// Half an hour at 250 Hz: a simulator left running does not fill the machine.
constexpr std::size_t kMaxTraceRows = 450'000;

/// A DAMIAO drive rounds what it says to its own codes; the encoder behind it is finer.
RobotConfig with_fine_encoders(RobotConfig robot) {
  constexpr double kFine = 1 << 20;
  for (DriveConfig& drive : robot.drives)
    if (drive.family == DriveFamily::kDamiao) drive.counts_per_turn = kFine;
  return robot;
}

}  // namespace

World::World(const RobotConfig& robot, const Scene& scene, Truth truth, Time start, Send send)
    : robot_(with_fine_encoders(robot)), plant_(robot_, scene, std::move(truth), start), before_(plant_.truth()) {
  const auto joints = static_cast<std::size_t>(robot.arm.joint_count());
  const auto is_canopen = [](const DriveConfig& drive) { return drive.family == DriveFamily::kCanopen; };
  opener_ = static_cast<std::size_t>(std::ranges::find_if(robot_.drives, is_canopen) - robot_.drives.begin());
  for (std::size_t i = 0; i <= joints; ++i)
    nodes_.push_back(make_node(i, [send, i](const CanFrame& frame, Time now) { send(i, frame, now); }));
}

std::unique_ptr<BusNode> World::make_node(std::size_t i, const SendFrame& send) {
  if (i == robot_.drives.size())
    return std::make_unique<DriveNode>(robot_.hand.node, send, plant_.hand_motor(), [this](std::int32_t, Time time) {
      if (opener_ == robot_.drives.size()) open_row(time, robot_.hand.bus);
    });
  const DriveConfig& drive = robot_.drives[i];
  Motor& motor = plant_.joint_motor(static_cast<int>(i));
  if (drive.family == DriveFamily::kDamiao) return std::make_unique<DamiaoDrive>(drive.node, drive.mit, send, motor);
  return std::make_unique<DriveNode>(drive.node, send, motor,
                                     [this, i](std::int32_t counts, Time time) { sample(i, counts, time); });
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

double World::reading_rad(std::size_t joint, std::int32_t counts) const {
  const DriveConfig& drive = robot_.drives[joint];
  return drive.sign * 2.0 * std::numbers::pi * counts / drive.counts_per_turn + drive.zero_rad;
}

void World::open_row(Time time, std::uint8_t bus) {
  if (trace_.size() >= kMaxTraceRows) {
    trace_is_cut_ = true;
    return;
  }
  const JointVector& q = plant_.q_real();
  trace_.push_back({time, q, JointVector::Zero(q.size())});
  for (std::size_t i = 0; i < robot_.drives.size(); ++i)  // those who sample at no SYNC, or at another bus'
    if (robot_.drives[i].family == DriveFamily::kDamiao || robot_.drives[i].bus != bus)
      trace_.back().q_reading[static_cast<Eigen::Index>(i)] =
          reading_rad(i, plant_.joint_motor(static_cast<int>(i)).position_counts());
}

void World::sample(std::size_t node, std::int32_t counts, Time time) {
  if (node == opener_) open_row(time, robot_.drives[node].bus);
  if (trace_.empty() || trace_.back().time != time) return;
  trace_.back().q_reading[static_cast<Eigen::Index>(node)] = reading_rad(node, counts);
}

}  // namespace armsight::sim
