// A simulated CiA 402 drive: the power state machine in front of a Motor. Modes: cyclic synchronous position and
// velocity, profile position, and homing where it stands (methods 35, 37).
//
//   switch-on disabled ─06► ready ─07► switched on ─0F► operation enabled ─02 or lost─► quick stop active (holds)
//          ▲ 00 from anywhere              fault ◄── following error ──┘      ▲──────0F, only after a release──┘
//
// Losing the controller (heartbeat, RPDO deadline, NMT) makes an enabled drive quick-stop by 0x6007 = 3; with
// 0x605A = 6 it then holds, powered. It follows again only after the controlword has left "enable operation" once: a
// controller that comes back late must notice.
#pragma once

#include "tools/sim/canopen_device.hpp"
#include "tools/sim/motor.hpp"

namespace armsight::sim {

/// The state that a controlword leads to; quick_stop_option is 0x605A, `fault_reset_edge` says that bit 7 rose.
DriveState next_drive_state(DriveState state, std::uint16_t controlword, std::uint32_t quick_stop_option,
                            bool fault_reset_edge);
/// State bits of the statusword, without the others.
std::uint16_t state_bits(DriveState state);

class DriveNode : public CanopenDevice {
 public:
  /// on_sample: told of every SYNC with the position that the drive reports; may be empty.
  using OnSample = std::function<void(std::int32_t position_counts, Time time)>;
  DriveNode(std::uint8_t node, SendFrame send, Motor& motor, OnSample on_sample = {});

  DriveState state() const { return state_; }
  /// A fault of its own, with its emergency message.
  void fail(std::uint16_t emergency, Time now) { fault(emergency, now); }
  /// As if something else had brought it there.
  void force(DriveState state);
  /// Never gets to "operation enabled": its enable input stays open.
  void hold_back(bool is_held) { is_held_back_ = is_held; }

 private:
  std::optional<std::uint32_t> live_value(ObjectAddress object) override;
  std::uint32_t judge(ObjectAddress object, std::uint32_t value) const override;
  bool is_receive_mappable(std::uint16_t index) const override;
  bool is_transmit_mappable(std::uint16_t index) const override;
  void act(Time now) override;
  void lose(Loss loss, Time now) override;
  void reset(Time now) override;
  void on_sync(Time now) override;

  void add_drive_objects();
  std::int32_t position();
  void act_on_bit_4(std::uint16_t controlword);
  void lead_target(Time now);
  void drive_motor();
  void fault(std::uint16_t code, Time now);
  std::uint16_t statusword() const;

  Motor& motor_;
  OnSample on_sample_;
  DriveState state_ = DriveState::kSwitchOnDisabled;
  std::uint16_t last_controlword_ = 0;
  bool is_held_back_ = false;
  bool must_release_ = false;  ///< stopped by itself: "enable operation" counts only after another command
  std::int32_t sampled_counts_ = 0;
  std::int32_t zero_ = 0;                ///< reported = motor + zero_; set by homing
  std::int32_t target_ = 0, profile_target_ = 0;
  double led_ = 0.0;                     ///< target_ with its fraction
  Time last_act_{};
  bool bit_4_was_up_ = false, is_acknowledged_ = false, is_homed_ = false;
};

}  // namespace armsight::sim
