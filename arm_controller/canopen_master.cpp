#include "arm_controller/canopen_master.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace armsight::arm {
namespace {

constexpr Duration kOwnHeartbeatPeriod = std::chrono::milliseconds(100);
constexpr int kFailedCyclesLimit = 3;
constexpr int kStateCycles = 10;
constexpr double kAnswerShare = 0.6;           ///< of a period: the answers take 1.7 ms on the bus (controller.md §3.2)
constexpr double kFastestJoint_rad_s = 10.0;   ///< above the actuator's 6 rad/s (specification §4.4)
constexpr double kEncoderNoise_rad = 0.01;
constexpr double kStepRemains_rad = 0.1;       ///< from the last position believed in, after a quick stop
constexpr double kFrozen_rad = 0.03;           ///< a set-point's way without one count of its encoder's
constexpr double kBeyondLimits_rad = 0.35;     ///< a whole turn off is always farther than this

double turn(const DriveConfig& drive) { return drive.sign * 2.0 * std::numbers::pi / drive.counts_per_turn; }

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
  // Both watch each other with the same patience; a slow bus needs its cycles to show a state.
  options.heartbeat_lost_after = seconds_to_duration(robot.controller.heartbeat_s);
  options.state_timeout = std::max(options.state_timeout, kStateCycles * seconds_to_duration(robot.controller.period_s));
  return options;
}

}  // namespace

CanopenMaster::CanopenMaster(const RobotConfig& robot, const std::optional<JointVector>& last_seen)
    : limits_(robot.arm.limits), hand_(robot.hand), period_s_(robot.controller.period_s),
      joint_count_(robot.arm.joint_count()), node_count_(joint_count_ + 1), bus_count_(static_cast<std::size_t>(robot.bus_count())),
      last_seen_(last_seen) {
  for (int i = 0; i < joint_count_; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    drives_[k] = robot.drives[k];
    bus_of_[k] = drives_[k].bus;
    nodes_[k].emplace(node_options(robot, drives_[k]));
  }
  DriveConfig hand;  // its counts a turn are nobody's concern
  hand.node = hand_.node;
  hand.mode = hand_.mode;
  bus_of_[static_cast<std::size_t>(joint_count_)] = hand_.bus;
  nodes_[static_cast<std::size_t>(joint_count_)].emplace(node_options(robot, hand));
  samples_.q_rad = samples_.torque_Nm = JointVector::Zero(joint_count_);
}

void CanopenMaster::latch(const Fault& fault) noexcept {
  if (!samples_.fault.is_set()) samples_.fault = fault;
}

void CanopenMaster::latch_on(FaultCode code, int bus) noexcept {
  Fault fault{code};
  if (bus_count_ > 1) fault.bus = static_cast<std::int8_t>(bus);
  latch(fault);
}

void CanopenMaster::take(const BusFrame& received, Time now) noexcept {
  if (received.bus >= bus_count_) return;
  if (received.is_own_echo) {
    SyncState& sync = syncs_[received.bus];
    if (received.frame.id == kSyncId && sync.is_out) sync.time = received.time;
    return;
  }
  for (int i = 0; i < node_count_; ++i)
    if (bus_of(i) == received.bus) node_at(i).receive(received.frame, now);
}

void CanopenMaster::finish_receiving(const BusErrors& errors, Time now) noexcept {
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

void CanopenMaster::take_errors(const BusErrors& errors) noexcept {
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

void CanopenMaster::update_phase() noexcept {
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

std::optional<SelfCheck> CanopenMaster::take_self_check() noexcept {
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

// A joint that was just told "here is zero" reads otherwise than a cycle ago, and has not moved.
void CanopenMaster::note_homing() noexcept {
  for (int i = 0; i < joint_count_; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    const bool is_homed = !node(i).needs_homing();
    if (is_homed && !was_homed_[k] && node(i).is_homed_by_us()) samples_.has_positions = false;
    was_homed_[k] = is_homed;
  }
}

// Against the last position that was known: in this run, or in an earlier one (controller.md §4.4).
void CanopenMaster::check_wrap(int joint, double q_rad) noexcept {
  WrapCheck& wrap = wraps_[static_cast<std::size_t>(joint)];
  wrap = {last_seen_.has_value() && !node(joint).is_homed_by_us(), 0.0, q_rad, Verdict::kDegraded};
  if (!wrap.is_known) return;
  wrap.last_rad = (*last_seen_)[joint];
  const double moved = q_rad - wrap.last_rad;
  wrap.verdict = is_about_a_whole_turn(moved) ? Verdict::kRefused : Verdict::kOk;
  if (wrap.verdict == Verdict::kRefused) latch({FaultCode::kWholeTurn, node(joint).id(), 0, 0, 0, 0, -1, moved});
}

void CanopenMaster::update_joints() noexcept {
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
    const DriveConfig& drive = drives_[static_cast<std::size_t>(i)];
    q[i] = turn(drive) * node(i).position_counts() + drive.zero_rad;
    samples_.torque_Nm[i] = drive.sign * 1e-3 * node(i).torque_permille() * node(i).rated_torque_Nm();
  }
  samples_.is_fresh = positions_are_plausible(q);
  if (!samples_.is_fresh) return;
  samples_.q_rad = q;
  last_seen_ = q;
  must_prove_positions_ = false;
  samples_.time = last_fresh_ = sampling_time();
  samples_.has_positions = true;
}

// An encoder jump must stop the arm and never reach the filter as an offset (controller.md §4.4, §10 no. 8).
bool CanopenMaster::positions_are_plausible(const JointVector& q) noexcept {
  const double farthest = kFastestJoint_rad_s * to_seconds(sampling_time() - last_fresh_) + kEncoderNoise_rad;
  for (int i = 0; i < joint_count_; ++i) {
    if (node(i).needs_homing()) continue;
    if (!samples_.has_positions) check_wrap(i, q[i]);
    const bool is_outside =
        q[i] < limits_.min_rad[i] - kBeyondLimits_rad || q[i] > limits_.max_rad[i] + kBeyondLimits_rad;
    if (!samples_.has_positions && is_outside) latch({FaultCode::kOutsideLimits, node(i).id()});
    const double remains = must_prove_positions_ ? q[i] - last_seen_->coeff(i) : 0.0;
    if (std::abs(remains) > kStepRemains_rad) latch({FaultCode::kEncoderStep, node(i).id(), 0, 0, 0, 0, -1, remains});
    if (samples_.has_positions && std::abs(q[i] - samples_.q_rad[i]) > farthest)
      latch({FaultCode::kEncoderStep, node(i).id(), 0, 0, 0, 0, -1, q[i] - samples_.q_rad[i]});
  }
  return !samples_.fault.is_set() || samples_.fault.code < FaultCode::kEncoderStep || is_plain_stop(samples_.fault.code);
}

void CanopenMaster::update_hand() noexcept {
  if (!hand_node().has_feedback()) return;
  const double stroke = hand_.closed_counts - hand_.open_counts;
  samples_.hand_closure = (hand_node().position_counts() - hand_.open_counts) / stroke;
  samples_.hand_effort_permille = std::abs(hand_node().torque_permille());
}

// What the nodes did while nobody could hear them is unknown: after a failure of the bus they begin anew. An encoder that
// stepped must read again what it read before: a step that remains would be learnt as an offset.
void CanopenMaster::recover(Time now) noexcept {
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

// The drive's own loop would chase what its encoder hides, ever faster.
void CanopenMaster::watch_encoder(int joint, double q_command_rad) noexcept {
  FrozenWatch& watch = frozen_[static_cast<std::size_t>(joint)];
  const std::int32_t counts = node(joint).position_counts();
  if (!node(joint).is_following() || counts != watch.counts) watch = {counts, q_command_rad};
  const double way = std::abs(q_command_rad - watch.q_command_rad);
  if (way > kFrozen_rad) latch({FaultCode::kEncoderFrozen, node(joint).id(), 0, 0, 0, 0, -1, way});
}

std::int32_t CanopenMaster::target_counts(int joint, double q_rad) const noexcept {
  const DriveConfig& drive = drives_[static_cast<std::size_t>(joint)];
  return static_cast<std::int32_t>(std::lround((q_rad - drive.zero_rad) / turn(drive)));
}

void CanopenMaster::add(const CanFrame& frame, std::size_t bus, Kind kind) noexcept {
  if (outgoing_count_ < outgoing_.size())
    outgoing_[outgoing_count_++] = {frame, static_cast<std::uint8_t>(bus), kind};
}

void CanopenMaster::add_on_all(const CanFrame& frame, Kind kind) noexcept {
  for (std::size_t bus = 0; bus < bus_count_; ++bus) add(frame, bus, kind);
}

// SYNCs of several buses end within a frame's time of each other: the middle stands for all joints.
Time CanopenMaster::sampling_time() const noexcept {
  Time first = syncs_[0].time, last = first;
  for (std::size_t bus = 1; bus < bus_count_; ++bus) {
    first = std::min(first, syncs_[bus].time);
    last = std::max(last, syncs_[bus].time);
  }
  return first + (last - first) / 2;
}

void CanopenMaster::prepare(const JointCommand& command, Time now) noexcept {
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
    const auto bend_counts = static_cast<std::int32_t>(std::lround(bend / turn(drives_[static_cast<std::size_t>(i)])));
    if (const auto frame = node_at(i).set_point(target_counts(i, q), bend_counts))
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
void CanopenMaster::note_sent(std::size_t i, SendResult result, Time now) noexcept {
  const Outgoing& sent = outgoing_[i];
  if (sent.kind == Kind::kSync && result == SendResult::kSent) {
    syncs_[sent.bus] = {true, now};  // until the echo tells better
    sync_sent_ = now;
  }
  if (result != SendResult::kSent && sent.kind != Kind::kOther) failed_bus_ = sent.bus;
  if (i + 1 != outgoing_count_) return;
  failed_cycles_ = failed_bus_ ? failed_cycles_ + 1 : 0;
  if (failed_cycles_ >= kFailedCyclesLimit) latch_on(FaultCode::kSendFailed, failed_bus_.value_or(0));
}

}  // namespace armsight::arm
