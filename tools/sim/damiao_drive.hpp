// A simulated DAMIAO drive in front of a Motor, with the traps that the real ones have: it wakes up disabled, within
// one turn, with its time-out off and in whatever mode it was left; in any mode but MIT it answers no command; when its
// time-out passes it lets go.
// Between them it is an impedance: what it gives is a torque, and how far the joint gives way its stiffness' business.
// A brake, which real ones lack, holds the joint without power.
#pragma once

#include <map>

#include "protocol/config.hpp"
#include "tools/sim/bus_node.hpp"
#include "tools/sim/motor.hpp"

namespace armsight::sim {

class DamiaoDrive : public BusNode {
 public:
  DamiaoDrive(std::uint8_t motor_id, const MitConfig& config, SendFrame send, Motor& motor);

  void power_on(Time now) override;
  void on_frame(const CanFrame& frame, Time now) override;
  void on_time(Time now) override;
  Time next_time() const override;
  void excuse(Duration stall) override;

  MitState state() const { return state_; }
  std::uint32_t register_value(MitRegister reg) const { return registers_.at(static_cast<std::uint8_t>(reg)); }
  void set_register(MitRegister reg, std::uint32_t value) { registers_[static_cast<std::uint8_t>(reg)] = value; }
  int set_zero_orders() const { return set_zero_orders_; }

  // Bends.
  std::uint32_t mode_at_power_on = kMitMode;
  std::optional<MitRegister> stuck;   ///< answers a write, and keeps its value
  bool is_silent = false;             ///< off the bus, without power
  int dropped_samples = 0;            ///< so many are not sent
  double push_Nm = 0.0;               ///< somebody leans on the joint, which the drive does not know
  int turns_at_power_on = 0;          ///< wakes up that many turns beside
  void fail(MitState state);

 private:
  bool answers_commands() const { return register_value(MitRegister::kControlMode) == kMitMode; }
  void take(const MitRequest& request, Time now);
  void obey(MitOrder order);
  void follow(const MitCommand& command);
  void let_go(MitState state);
  void renew_deadline(Time now);
  void send_sample(Time now);
  void send_answer(std::uint8_t reg, std::uint32_t value, bool is_write, Time now);
  double position_rad();
  double count_rad() const;

  std::uint8_t motor_id_;
  MitConfig config_;
  SendFrame send_;
  Motor& motor_;
  std::map<std::uint8_t, std::uint32_t> registers_;
  MitState state_ = MitState::kDisabled;
  double woke_beside_rad_ = 0.0;
  std::optional<Time> deadline_;
  int set_zero_orders_ = 0;
  double last_position_rad_ = 0.0, speed_rad_s_ = 0.0;
  Time last_sample_{};
};

}  // namespace armsight::sim
