// DriveMaster, second part: may the positions that the drives report be believed?
#include <cmath>
#include <limits>
#include <numbers>

#include "arm_controller/drive_master.hpp"

namespace armsight::arm {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kFastestJoint_rad_s = 10.0;   ///< above the actuator's 6 rad/s (specification §4.4)
constexpr double kEncoderNoise_rad = 0.01;
constexpr double kStepRemains_rad = 0.1;       ///< from the last position believed in, after a quick stop
constexpr double kFrozen_rad = 0.03;           ///< a set-point's way without one count of its encoder's
constexpr int kFrozenCycles = 5;               ///< a set-point acts with the next SYNC, and shows with the one after that
constexpr double kBeyondLimits_rad = 0.35;     ///< a whole turn off is always farther than this

}  // namespace

// A joint that was just told "here is zero" reads otherwise than a cycle ago, and has not moved.
void DriveMaster::note_homing() noexcept {
  for (int i = 0; i < joint_count_; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    const bool is_homed = !node(i).needs_homing();
    if (is_homed && !was_homed_[k] && node(i).is_homed_by_us()) samples_.has_positions = false;
    was_homed_[k] = is_homed;
  }
}

// Against the last position that was known: in this run, or in an earlier one (controller.md §4.4).
void DriveMaster::check_wrap(int joint, double q_rad) noexcept {
  WrapCheck& wrap = wraps_[static_cast<std::size_t>(joint)];
  wrap = {last_seen_.has_value() && !node(joint).is_homed_by_us(), 0.0, q_rad, Verdict::kDegraded};
  if (!wrap.is_known) return;
  wrap.last_rad = (*last_seen_)[joint];
  const double moved = q_rad - wrap.last_rad;
  const bool is_known_joint = drives_[static_cast<std::size_t>(joint)].is_commissioned;
  wrap.verdict = is_known_joint && is_about_a_whole_turn(moved) ? Verdict::kRefused : Verdict::kOk;
  if (wrap.verdict == Verdict::kRefused) latch({FaultCode::kWholeTurn, node(joint).id(), 0, 0, 0, 0, -1, moved});
}

// A drive that knows where it is within a turn only woke up in the one that its joint's limits allow. Where they allow
// several, the last known position tells; where that is not known either, nobody can.
void DriveMaster::settle_turns(int joint) noexcept {
  const DriveConfig& drive = drives_[static_cast<std::size_t>(joint)];
  JointDrive& woken = node_at(joint);
  woken.set_turns(0);
  if (!drive.is_commissioned) return;  // what it counts means nothing yet
  const double q = drive.sign * woken.position_rad(sampling_time()) + drive.zero_rad;
  int fitting = 0, chosen = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (const int turns : {-1, 0, 1}) {
    const double there = q + turns * kTurn_rad;
    if (there < limits_.min_rad[joint] - kBeyondLimits_rad || there > limits_.max_rad[joint] + kBeyondLimits_rad) continue;
    ++fitting;
    const double moved = last_seen_ ? std::abs(there - (*last_seen_)[joint]) : 0.0;
    if (moved >= nearest) continue;
    nearest = moved;
    chosen = turns;
  }
  if (fitting > 1 && (!last_seen_ || nearest > kWholeTurnSlack_rad)) return latch({FaultCode::kTurnUnknown, woken.id()});
  woken.set_turns(drive.sign * chosen);
}

// An encoder jump must stop the arm and never reach the filter as an offset (controller.md §4.4, §10 no. 8).
bool DriveMaster::positions_are_plausible(const JointVector& q) noexcept {
  const double farthest = kFastestJoint_rad_s * to_seconds(sampling_time() - last_fresh_) + kEncoderNoise_rad;
  for (int i = 0; i < joint_count_; ++i) {
    if (node(i).needs_homing()) continue;
    if (!samples_.has_positions) check_wrap(i, q[i]);
    const bool is_outside =
        q[i] < limits_.min_rad[i] - kBeyondLimits_rad || q[i] > limits_.max_rad[i] + kBeyondLimits_rad;
    const bool has_zero = drives_[static_cast<std::size_t>(i)].is_commissioned;
    if (!samples_.has_positions && is_outside && has_zero) latch({FaultCode::kOutsideLimits, node(i).id()});
    const double remains = must_prove_positions_ ? q[i] - last_seen_->coeff(i) : 0.0;
    if (std::abs(remains) > kStepRemains_rad) latch({FaultCode::kEncoderStep, node(i).id(), 0, 0, 0, 0, -1, remains});
    if (samples_.has_positions && std::abs(q[i] - samples_.q_rad[i]) > farthest)
      latch({FaultCode::kEncoderStep, node(i).id(), 0, 0, 0, 0, -1, q[i] - samples_.q_rad[i]});
  }
  return !samples_.fault.is_set() || samples_.fault.code < FaultCode::kEncoderStep || is_plain_stop(samples_.fault.code);
}

// The drive's own loop would chase what its encoder hides, ever faster.
void DriveMaster::watch_encoder(int joint, double q_command_rad) noexcept {
  FrozenWatch& watch = frozen_[static_cast<std::size_t>(joint)];
  const std::int32_t counts = node(joint).position_counts();
  if (!node(joint).is_following() || counts != watch.counts) watch = {counts, q_command_rad};
  const double way = std::abs(q_command_rad - watch.q_command_rad);
  if (++watch.cycles > kFrozenCycles && way > kFrozen_rad)
    latch({FaultCode::kEncoderFrozen, node(joint).id(), 0, 0, 0, 0, -1, way});
}

}  // namespace armsight::arm
