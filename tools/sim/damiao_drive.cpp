#include "tools/sim/damiao_drive.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include "tools/sim/bus_model.hpp"

namespace armsight::sim {

namespace {

constexpr double kWholeTurn_rad = 2.0 * std::numbers::pi;
constexpr double kRatedTorque_Nm = 6.0;          // actuator of specification §4.4
constexpr double kShortestForSpeed_s = 0.0005;
constexpr std::uint32_t kVersionNumber = 5013;
constexpr std::uint8_t kWarm_C = 31;

std::uint32_t bits_of(double value) { return std::bit_cast<std::uint32_t>(static_cast<float>(value)); }
constexpr std::uint8_t number(MitRegister reg) { return static_cast<std::uint8_t>(reg); }

}  // namespace

DamiaoDrive::DamiaoDrive(std::uint8_t motor_id, const MitConfig& config, SendFrame send, Motor& motor)
    : motor_id_(motor_id), config_(config), send_(std::move(send)), motor_(motor) {
  power_on(Time{});
}

double DamiaoDrive::count_rad() const { return kWholeTurn_rad / motor_.counts_per_turn(); }

double DamiaoDrive::position_rad() { return motor_.position_counts() * count_rad() + woke_beside_rad_; }

void DamiaoDrive::power_on(Time now) {
  state_ = MitState::kDisabled;
  deadline_.reset();
  registers_ = {{number(MitRegister::kReplyId), config_.reply_id},
                {number(MitRegister::kMotorId), motor_id_},
                {number(MitRegister::kTimeout), 0},
                {number(MitRegister::kControlMode), mode_at_power_on},
                {number(MitRegister::kVersion), kVersionNumber},
                {number(MitRegister::kPositionRange), bits_of(config_.ranges.position_rad)},
                {number(MitRegister::kSpeedRange), bits_of(config_.ranges.speed_rad_s)},
                {number(MitRegister::kTorqueRange), bits_of(config_.ranges.torque_Nm)}};
  const double turned = motor_.position_counts() * count_rad();
  woke_beside_rad_ = kWholeTurn_rad * (turns_at_power_on - std::round(turned / kWholeTurn_rad));
  last_position_rad_ = position_rad();
  last_sample_ = now;
  motor_.command(MotorMode::kOff, 0, 0);
}

void DamiaoDrive::fail(MitState state) { let_go(state); }

void DamiaoDrive::let_go(MitState state) {
  state_ = state;
  deadline_.reset();
  motor_.command(MotorMode::kOff, 0, 0);
}

void DamiaoDrive::on_frame(const CanFrame& frame, Time now) {
  if (is_silent || (frame.is_fd && !config_.is_fd)) return;
  if (const auto request = decode_mit_request(frame, motor_id_, config_.ranges)) take(*request, now);
}

void DamiaoDrive::take(const MitRequest& request, Time now) {
  using Kind = MitRequest::Kind;
  switch (request.kind) {
    case Kind::kRead: {
      const auto found = registers_.find(request.reg);
      if (found != registers_.end()) send_answer(request.reg, found->second, false, now);
      return;
    }
    case Kind::kWrite: {
      const bool is_kept = stuck && number(*stuck) == request.reg;
      if (!is_kept && registers_.contains(request.reg)) registers_[request.reg] = request.value;
      renew_deadline(now);
      return send_answer(request.reg, request.value, true, now);
    }
    case Kind::kRefresh: return send_sample(now);
    case Kind::kSetZero:
      ++set_zero_orders_;
      woke_beside_rad_ -= position_rad();
      return send_sample(now);
    case Kind::kOrder:
      if (!answers_commands()) return;
      obey(request.order);
      break;
    case Kind::kCommand:
      if (!answers_commands()) return;
      follow(request.command);
      break;
  }
  renew_deadline(now);
  send_sample(now);
}

void DamiaoDrive::obey(MitOrder order) {
  if (order == MitOrder::kEnable && state_ == MitState::kDisabled) state_ = MitState::kEnabled;
  if (order == MitOrder::kDisable && state_ == MitState::kEnabled) let_go(MitState::kDisabled);
  if (order == MitOrder::kClearFault && is_mit_fault(state_)) let_go(MitState::kDisabled);
}

void DamiaoDrive::follow(const MitCommand& command) {
  if (state_ != MitState::kEnabled) return;
  motor_.command({(command.position_rad - woke_beside_rad_) / count_rad(), command.speed_rad_s, command.kp_Nm_rad,
                  command.kd_Nms_rad, command.torque_Nm + push_Nm, config_.ranges.torque_Nm});
}

void DamiaoDrive::renew_deadline(Time now) {
  deadline_.reset();
  const std::uint32_t units = register_value(MitRegister::kTimeout);
  if (state_ == MitState::kEnabled && units != 0) deadline_ = now + seconds_to_duration(units * kMitTimeoutUnit_s);
}

void DamiaoDrive::on_time(Time now) {
  if (deadline_ && *deadline_ <= now) let_go(MitState::kCommandsLost);
}

Time DamiaoDrive::next_time() const { return deadline_.value_or(kNever); }

void DamiaoDrive::excuse(Duration stall) {
  if (deadline_) *deadline_ += stall;
}

void DamiaoDrive::send_sample(Time now) {
  if (dropped_samples > 0) {
    --dropped_samples;
    return;
  }
  const double position = position_rad(), dt_s = to_seconds(now - last_sample_);
  if (dt_s > kShortestForSpeed_s) {
    speed_rad_s_ = (position - last_position_rad_) / dt_s;
    last_position_rad_ = position;
    last_sample_ = now;
  }
  const double torque_Nm = 1e-3 * kRatedTorque_Nm * motor_.torque_permille();
  const MitSample sample{state_, position, speed_rad_s_, torque_Nm, kWarm_C, kWarm_C};
  CanFrame frame = encode(sample, config_.reply_id, motor_id_, config_.ranges);
  frame.is_fd = config_.is_fd;
  send_(frame, now);
}

void DamiaoDrive::send_answer(std::uint8_t reg, std::uint32_t value, bool is_write, Time now) {
  CanFrame frame = encode_mit_answer(reg, value, is_write, config_.reply_id, motor_id_);
  frame.is_fd = config_.is_fd;
  send_(frame, now);
}

}  // namespace armsight::sim
