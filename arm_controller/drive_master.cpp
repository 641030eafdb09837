#include "arm_controller/drive_master.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace armsight::arm {
namespace {

constexpr Duration kOwnHeartbeatPeriod = std::chrono::milliseconds(100);
constexpr int kFailedCyclesLimit = 3;
constexpr int kStateCycles = 10;
constexpr double kAnswerShare = 0.6;           ///< of a period: the answers take 1.7 ms on the bus (controller.md §3.2)

NodeOptions node_options(const RobotConfig& robot, const DriveConfig& drive) {
  NodeOptions options;
  options.script.node = drive.node;
  options.script.mode = drive.mode;
  options.script.homing_method = drive.homing_method;
  options.period_s = robot.controller.period_s;
  options.script.period_us = static_cast<std::uint32_t>(std::lround(1e6 * robot.controller.period_s));
  options.script.rpdo_deadline_ms = static_cast<std::uint16_t>(std::lround(1e3 * robot.controller.rpdo_deadline_s));
  options.script.controller_heartbeat_ms = static_cast<std::uint16_t>(std::lround(1e3 * robot.controller.heartbeat_s));
  options.counts_per_turn = drive.counts_per_turn;
  options.gear = drive.gear;
  options.stiffness_object = drive.stiffness_object;
  options.script.stiffness_object = drive.stiffness_object;
  options.script.stiffness_permille = drive.stiffness_permille;
  // Both watch each other with the same patience; a slow bus needs its cycles to show a state.
  options.heartbeat_lost_after = seconds_to_duration(robot.controller.heartbeat_s);
  options.state_timeout = std::max(options.state_timeout, kStateCycles * seconds_to_duration(robot.controller.period_s));
  return options;
}

MitOptions mit_options(const RobotConfig& robot, const DriveConfig& drive) {
  MitOptions options;
  options.motor = drive.node;
  options.drive = drive.mit;
  options.period_s = robot.controller.period_s;
  options.timeout_s = robot.controller.rpdo_deadline_s;
  options.state_timeout = std::max(options.state_timeout, kStateCycles * seconds_to_duration(robot.controller.period_s));
  return options;
}

}  // namespace

DriveMaster::DriveMaster(const RobotConfig& robot, const std::optional<JointVector>& last_seen)
    : limits_(robot.arm.limits), hand_(robot.hand), period_s_(robot.controller.period_s),
      joint_count_(robot.arm.joint_count()), node_count_(joint_count_ + 1), bus_count_(static_cast<std::size_t>(robot.bus_count())),
      last_seen_(last_seen) {
  for (int i = 0; i < joint_count_; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    drives_[k] = robot.drives[k];
    bus_of_[k] = drives_[k].bus;
    if (drives_[k].family == DriveFamily::kDamiao) nodes_[k].emplace(mit_options(robot, drives_[k]));
    else nodes_[k].emplace(node_options(robot, drives_[k]));
  }
  DriveConfig hand;  // its counts a turn are nobody's concern
  hand.node = hand_.node;
  hand.mode = hand_.mode;
  bus_of_[static_cast<std::size_t>(joint_count_)] = hand_.bus;
  nodes_[static_cast<std::size_t>(joint_count_)].emplace(node_options(robot, hand));
  samples_.q_rad = samples_.torque_Nm = JointVector::Zero(joint_count_);
  for (int i = 0; i < node_count_; ++i)
    if (node(i).hears_sync()) has_sync_[bus_of(i)] = true;
}

void DriveMaster::latch(const Fault& fault) noexcept {
  if (!samples_.fault.is_set()) samples_.fault = fault;
}

void DriveMaster::latch_on(FaultCode code, int bus) noexcept {
  Fault fault{code};
  if (bus_count_ > 1) fault.bus = static_cast<std::int8_t>(bus);
  latch(fault);
}

void DriveMaster::take(const BusFrame& received, Time now) noexcept {
  if (received.bus >= bus_count_) return;
  if (received.is_own_echo) {
    SyncState& sync = syncs_[received.bus];
    if (received.frame.id == kSyncId && sync.is_out) sync.time = received.time;
    return;
  }
  for (int i = 0; i < node_count_; ++i)
    if (bus_of(i) == received.bus) node_at(i).receive(received, now);
}

void DriveMaster::finish_receiving(const BusErrors& errors, Time now) noexcept {
  take_errors(errors);
  // A cycle that follows a late one comes too soon for the answers to its SYNC: that is our lateness, not the nodes'.
  const bool is_time = now - sync_sent_ >= seconds_to_duration(kAnswerShare * period_s_);
  for (int i = 0; i < node_count_; ++i) {
    const bool is_due = is_time && syncs_[bus_of(i)].is_out;
    node_at(i).advance(now, is_due, samples_.fault.is_set() ? PowerRequest::kQuickStop : power_);
    latch(node(i).fault());
  }
  update_phase();
  update_joints();
  update_hand();
  for (SyncState& sync : syncs_) sync.is_out = false;
}

void DriveMaster::take_errors(const BusErrors& errors) noexcept {
  error_totals_.error_frames += errors.error_frames;
  error_totals_.send_failures += errors.send_failures;
  error_totals_.receive_overflows += errors.receive_overflows;
  error_totals_.lost = error_totals_.lost || errors.lost;
  const auto latch_for = [this](FaultCode code, bool is_any, std::uint8_t buses) {
    if (is_any || buses != 0) latch_on(code, buses == 0 ? 0 : std::countr_zero(buses));
  };
  latch_for(FaultCode::kBusLost, errors.lost, errors.lost_buses);
  latch_for(FaultCode::kBusOff, errors.bus_off, errors.bus_off_buses);
}

void DriveMaster::update_phase() noexcept {
  bool all_seen = true, all_ready = true, all_follow = true;
  for (int i = 0; i < node_count_; ++i) {
    all_seen = all_seen && node(i).phase() != NodePhase::kAbsent;
    all_ready = all_ready && node(i).phase() == NodePhase::kReady && !node(i).is_resetting();
    all_follow = all_follow && node(i).is_following();
  }
  samples_.phase = !all_seen     ? BusPhase::kDown
                   : !all_ready  ? BusPhase::kConfiguring
                   : !all_follow ? BusPhase::kReady
                                 : BusPhase::kPowered;
}

std::optional<SelfCheck> DriveMaster::take_self_check() noexcept {
  if (!self_check_is_due_) return std::nullopt;
  bool all_ready = true;
  for (int i = 0; i < node_count_; ++i) {
    if (node(i).phase() != NodePhase::kReady && !node(i).fault().is_set()) return std::nullopt;
    all_ready = all_ready && node(i).phase() == NodePhase::kReady;
  }
  if (all_ready && !samples_.has_positions && !samples_.fault.is_set()) return std::nullopt;
  self_check_is_due_ = false;
  SelfCheck check;
  check.node_count = node_count_;
  check.wraps = wraps_;
  for (int i = 0; i < node_count_; ++i) check.nodes[static_cast<std::size_t>(i)] = node(i).check();
  return check;
}

void DriveMaster::update_joints() noexcept {
  bool all_fresh = true, all_known = true;
  for (int i = 0; i < joint_count_; ++i) {
    all_fresh = all_fresh && syncs_[bus_of(i)].is_out && node(i).is_fresh();
    all_known = all_known && node(i).has_feedback();
  }
  samples_.is_fresh = all_fresh && all_known;
  if (!samples_.is_fresh) return;
  note_homing();
  JointVector q(joint_count_);
  for (int i = 0; i < joint_count_; ++i) {
    if (!samples_.has_positions && node(i).is_single_turn()) settle_turns(i);
    const DriveConfig& drive = drives_[static_cast<std::size_t>(i)];
    q[i] = drive.sign * node(i).position_rad(sampling_time()) + drive.zero_rad;
    samples_.torque_Nm[i] = drive.sign * node(i).torque_Nm();
  }
  samples_.is_fresh = positions_are_plausible(q);
  if (!samples_.is_fresh) return;
  samples_.q_rad = q;
  last_seen_ = q;
  must_prove_positions_ = false;
  samples_.time = last_fresh_ = sampling_time();
  samples_.has_positions = true;
}

void DriveMaster::update_hand() noexcept {
  const Node& hand = hand_node();
  if (!hand.has_feedback()) return;
  const double stroke = hand_.closed_counts - hand_.open_counts;
  samples_.hand_closure = (hand.position_counts() - hand_.open_counts) / stroke;
  samples_.hand_effort_permille = std::abs(hand.torque_permille());
}

// What the nodes did while nobody could hear them is unknown: after a failure of the bus they begin anew. An encoder that
// stepped must read again what it read before: a step that remains would be learnt as an offset.
void DriveMaster::recover(Time now) noexcept {
  const FaultCode code = samples_.fault.code;
  const bool was_bus = code == FaultCode::kBusLost || code == FaultCode::kBusOff || code == FaultCode::kSendFailed;
  if (code == FaultCode::kEncoderStep) must_prove_positions_ = last_seen_.has_value();
  samples_.fault = {};
  samples_.has_positions = false;
  self_check_is_due_ = true;
  failed_cycles_ = 0;
  for (int i = 0; i < node_count_; ++i) {
    if (was_bus) node_at(i).restart(now);
    else node_at(i).recover(now);
  }
}

void DriveMaster::add(const CanFrame& frame, std::size_t bus, Kind kind) noexcept {
  if (outgoing_count_ < outgoing_.size())
    outgoing_[outgoing_count_++] = {frame, static_cast<std::uint8_t>(bus), kind};
}

/// Where a node listens to it.
void DriveMaster::add_on_all(const CanFrame& frame, Kind kind) noexcept {
  for (std::size_t bus = 0; bus < bus_count_; ++bus)
    if (has_sync_[bus]) add(frame, bus, kind);
}

// SYNCs of several buses end within a frame's time of each other: the middle stands for all joints.
Time DriveMaster::sampling_time() const noexcept {
  std::optional<Time> first, last;
  for (std::size_t bus = 0; bus < bus_count_; ++bus) {
    if (!has_sync_[bus]) continue;
    first = std::min(first.value_or(syncs_[bus].time), syncs_[bus].time);
    last = std::max(last.value_or(syncs_[bus].time), syncs_[bus].time);
  }
  return first ? *first + (*last - *first) / 2 : sync_sent_;
}

void DriveMaster::prepare(const JointCommand& command, Time now) noexcept {
  outgoing_count_ = 0;
  failed_bus_.reset();
  if (command.recover) recover(now);
  power_ = command.power;
  if (!has_begun_) {  // before the first SYNC: set-points that somebody left behind would act with it
    has_begun_ = true;
    return add_on_all(encode(Nmt{NmtCommand::kPreOperational, 0}), Kind::kOther);
  }
  if (power_ == PowerRequest::kQuickStop)  // all of them in this very cycle, whoever failed
    for (int i = 0; i < node_count_; ++i) node_at(i).stop(now);
  sync_counter_ = static_cast<std::uint8_t>(sync_counter_ % 10 + 1);
  add_on_all(encode(Sync{sync_counter_}), Kind::kSync);
  for (int i = 0; i < joint_count_; ++i) {
    const double q = i < command.q_rad.size() ? command.q_rad[i] : samples_.q_rad[i];
    watch_encoder(i, q);
    const double bend = i < command.bend_rad.size() ? command.bend_rad[i] : 0.0;
    const DriveConfig& drive = drives_[static_cast<std::size_t>(i)];
    const double torque = i < command.torque_Nm.size() ? command.torque_Nm[i] : 0.0;
    const auto k = static_cast<std::size_t>(i);
    const DriveTarget target{drive.sign * (q - drive.zero_rad), drive.sign * bend, drive.sign * torque,
                             command.stiffness_permille[k], command.stiffness_goal_permille[k]};
    if (const auto frame = node_at(i).set_target(target))
      add(*frame, bus_of(i), Kind::kSetPoint);
  }
  const double stroke = hand_.closed_counts - hand_.open_counts;
  const bool goes_by_itself = hand_.mode == DriveMode::kProfilePosition;
  const double closure = std::clamp(goes_by_itself ? command.hand_goal : command.hand_closure, 0.0, 1.0);
  hand_node().set_torque_limit(command.hand_force_permille);
  // The fingers move only under the grip limit that was asked for.
  const auto counts = hand_node().torque_limit_is_set()
                          ? static_cast<std::int32_t>(std::lround(hand_.open_counts + closure * stroke))
                          : hand_node().position_counts();
  if (const auto frame = hand_node().set_point(counts)) add(*frame, hand_.bus, Kind::kSetPoint);
  for (int i = 0; i < node_count_; ++i)
    if (const auto frame = node_at(i).service_frame(now)) add(*frame, bus_of(i), Kind::kOther);
  if (!own_heartbeat_ || now - *own_heartbeat_ >= kOwnHeartbeatPeriod) {
    add_on_all(encode(Heartbeat{NmtState::kOperational}, kControllerNode), Kind::kOther);
    own_heartbeat_ = now;
  }
}

// A frame that finds no room is dropped and counted, never queued: a stale set-point is worse than none.
void DriveMaster::note_sent(std::size_t i, SendResult result, Time now) noexcept {
  const Outgoing& sent = outgoing_[i];
  const bool opens_cycle = sent.kind == Kind::kSync || (sent.kind == Kind::kSetPoint && !has_sync_[sent.bus]);
  if (opens_cycle && result == SendResult::kSent) {
    syncs_[sent.bus] = {true, now};  // until the echo tells better
    sync_sent_ = now;
  }
  if (result != SendResult::kSent && sent.kind != Kind::kOther) failed_bus_ = sent.bus;
  if (i + 1 != outgoing_count_) return;
  failed_cycles_ = failed_bus_ ? failed_cycles_ + 1 : 0;
  if (failed_cycles_ >= kFailedCyclesLimit) latch_on(FaultCode::kSendFailed, failed_bus_.value_or(0));
}

}  // namespace armsight::arm
