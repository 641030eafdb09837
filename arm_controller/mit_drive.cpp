#include "arm_controller/mit_drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace armsight::arm {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

}  // namespace

MitDrive::MitDrive(const MitOptions& options) noexcept : options_(options) {
  check_.node = id();
  check_.family = DriveFamily::kDamiao;
}

void MitDrive::latch(const Fault& fault) noexcept {
  if (fault_.is_set()) return;
  fault_ = fault;
  fault_.family = DriveFamily::kDamiao;
  check_.fault = fault_;
}

void MitDrive::latch(FaultCode code, MitRegister reg, std::uint32_t got, std::uint32_t wanted) noexcept {
  latch({code, id(), static_cast<std::uint16_t>(reg), 0, got, wanted});
}

void MitDrive::latch_state(FaultCode code) noexcept {
  latch({code, id(), 0, 0, static_cast<std::uint32_t>(sample_.state)});
}

void MitDrive::restart(Time now) noexcept {
  phase_ = NodePhase::kAbsent;
  phase_since_ = now;
  fault_ = {};
  check_ = {};
  check_.node = id();
  check_.family = DriveFamily::kDamiao;
  step_ = 0;
  job_ = Job::kNone;
  has_sample_ = sample_arrived_ = was_enabled_ = false;
  missed_ = samples_seen_ = turns_ = 0;
  held_rad_.reset();
  last_target_rad_.reset();
}

// Its registers are volatile: whatever was wrong, they are asked again. The clear is the leave to reset a fault of its.
void MitDrive::recover(Time now) noexcept {
  const bool knows_where = has_sample_;
  const std::optional<double> held_rad = held_rad_;
  restart(now);
  has_sample_ = knows_where;  // one that holds is held on meanwhile: left alone it would let go
  held_rad_ = held_rad;
  may_clear_ = true;
}

double MitDrive::offset_rad() const noexcept { return turns_ * kTurn_rad; }

void MitDrive::set_turns(int turns) noexcept {
  turns_ = turns;
  check_.mit.turns = turns;
}

double MitDrive::position_rad(Time at) const noexcept {
  return sample_.position_rad + offset_rad() + sample_.speed_rad_s * to_seconds(at - sample_time_);
}

std::int32_t MitDrive::position_counts() const noexcept {
  constexpr double kCodes = 65535.0;
  return static_cast<std::int32_t>(std::lround(sample_.position_rad / (2.0 * options_.drive.ranges.position_rad) * kCodes));
}

void MitDrive::receive(const CanFrame& frame, Time end) noexcept {
  if (take_answer(frame)) return;
  const auto sample = decode_mit_sample(frame, options_.drive.reply_id, id(), options_.drive.ranges);
  if (!sample) return;
  sample_ = *sample;
  sample_time_ = end;
  has_sample_ = sample_arrived_ = true;
}

void MitDrive::advance(Time now, bool is_due, PowerRequest power) noexcept {
  if (!phase_since_) phase_since_ = now;
  if (!fault_.is_set()) {
    if (phase_ == NodePhase::kAbsent || phase_ == NodePhase::kConfiguring) advance_registers(now);
    if (phase_ == NodePhase::kStarting || phase_ == NodePhase::kReady) supervise_samples(now, is_due);
    if (phase_ == NodePhase::kStarting) advance_start(now);
  }
  if (phase_ == NodePhase::kReady) advance_power(now, fault_.is_set() ? PowerRequest::kQuickStop : power);
  is_fresh_ = sample_arrived_;
  sample_arrived_ = false;
}

void MitDrive::supervise_samples(Time now, bool is_due) noexcept {
  if (sample_arrived_) {
    missed_ = 0;
    ++samples_seen_;
  } else if (is_due && phase_ == NodePhase::kReady && ++missed_ >= kMissedLimit) {
    latch({FaultCode::kFeedbackMissing, id(), 0, 0, 0, 0, (now - sample_time_).count()});
  }
}

// A drive that an earlier commander left alone says "commands lost": it waited for us. Other faults are told, and reset
// only after a clear.
void MitDrive::advance_start(Time now) noexcept {
  const bool is_resettable = may_clear_ || sample_.state == MitState::kCommandsLost;
  const bool is_well = !is_mit_fault(sample_.state) || !is_resettable;
  if (has_sample_ && samples_seen_ >= kSamplesToStart && is_well) {
    phase_ = NodePhase::kReady;
    phase_since_ = now;
    check_.is_ready = true;
    may_clear_ = false;
    return;
  }
  if (now - *phase_since_ < kStartTimeout) return;
  if (has_sample_ && is_mit_fault(sample_.state)) return latch_state(FaultCode::kFaultResetFailed);
  latch({FaultCode::kFeedbackMissing, id(), 0, 0, 0, 0, has_sample_ ? (now - sample_time_).count() : -1});
}

void MitDrive::advance_power(Time now, PowerRequest power) noexcept {
  if (power != power_) power_since_ = now;
  const bool begins_to_stop = power == PowerRequest::kQuickStop && power_ != PowerRequest::kQuickStop;
  power_ = power;
  if (is_mit_fault(sample_.state)) return latch_state(FaultCode::kDriveFault);
  if (begins_to_stop) {
    held_rad_ = sample_.position_rad;
    stop_speed_rad_s_ = sample_.speed_rad_s;
  }
  if (power != PowerRequest::kOn) {
    was_enabled_ = false;
    return;
  }
  const bool is_enabled = sample_.state == MitState::kEnabled;
  if (was_enabled_ && !is_enabled) return latch_state(FaultCode::kDriveLeftOperation);
  was_enabled_ = is_enabled;
  if (!is_enabled && now - power_since_ > options_.state_timeout) latch_state(FaultCode::kEnableTimeout);
}

CanFrame MitDrive::framed(CanFrame frame) const noexcept {
  frame.is_fd = options_.drive.is_fd;
  return frame;
}

CanFrame MitDrive::command(double position_rad, double speed_rad_s) const noexcept {
  const MitCommand command{position_rad, speed_rad_s, kp_Nm_rad_, kd_Nms_rad_, torque_Nm_};
  return framed(encode(command, id(), options_.drive.ranges));
}

/// From the softest at 0 to the robot file's stiffness; the damping goes with its root, so that the joint swings no more
/// when soft.
void MitDrive::take_stiffness(std::uint16_t permille) noexcept {
  const MitConfig& drive = options_.drive;
  const double share = std::min(1e-3 * permille, 1.0);
  kp_Nm_rad_ = drive.softest_kp_Nm_rad + share * (drive.kp_Nm_rad - drive.softest_kp_Nm_rad);
  kd_Nms_rad_ = drive.kd_Nms_rad * std::sqrt(kp_Nm_rad_ / drive.kp_Nm_rad);
}

/// At rest where it is, or on the ramp to rest.
CanFrame MitDrive::hold() noexcept {
  if (!held_rad_) held_rad_ = sample_.position_rad;
  const double step = kQuickStop_rad_s2 * options_.period_s;
  stop_speed_rad_s_ -= std::clamp(stop_speed_rad_s_, -step, step);
  *held_rad_ += stop_speed_rad_s_ * options_.period_s;
  return command(*held_rad_, stop_speed_rad_s_);
}

std::optional<CanFrame> MitDrive::set_target(const DriveTarget& target) noexcept {
  take_stiffness(target.stiffness_permille);
  torque_Nm_ = target.torque_Nm;
  const bool is_enabled = sample_.state == MitState::kEnabled;
  if (phase_ == NodePhase::kAbsent || phase_ == NodePhase::kConfiguring) {
    // An arm that held when it was cleared is held while its registers are asked again.
    return has_sample_ && is_enabled ? std::optional(hold()) : std::nullopt;
  }
  if (phase_ == NodePhase::kStarting && is_mit_fault(sample_.state) &&
      (may_clear_ || sample_.state == MitState::kCommandsLost))
    return framed(encode(MitOrder::kClearFault, id()));
  const bool is_led = is_following() && power_ == PowerRequest::kOn && !fault_.is_set();
  if (!is_led) last_target_rad_.reset();
  if (power_ == PowerRequest::kOff && is_enabled) return framed(encode(MitOrder::kDisable, id()));
  if (power_ == PowerRequest::kOn && !is_enabled && !is_mit_fault(sample_.state) && phase_ == NodePhase::kReady)
    return framed(encode(MitOrder::kEnable, id()));
  if (!is_enabled) {
    held_rad_.reset();
    stop_speed_rad_s_ = 0.0;
    return framed(encode_mit_refresh(id()));
  }
  if (!is_led) return hold();
  held_rad_.reset();
  stop_speed_rad_s_ = 0.0;
  const double raw_rad = target.position_rad - offset_rad();
  const double speed_rad_s = (raw_rad - last_target_rad_.value_or(raw_rad)) / options_.period_s;
  last_target_rad_ = raw_rad;
  return command(raw_rad + target.bend_rad, speed_rad_s);
}

}  // namespace armsight::arm
