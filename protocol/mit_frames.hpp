// Frames of the MIT / DAMIAO drives ↔ structs, without I/O (controller.md §4.6): one 8-byte impedance command a cycle and
// drive, answered by one 8-byte sample; registers through one identifier for all. Big-endian bits in commands and samples,
// little-endian registers. Classic CAN and CAN FD carry the same eight bytes.
//
//   command  id = motor     q 16 | speed 12 | Kp 12 | Kd 12 | torque 12
//   sample   id = reply     state 4, motor 4 | q 16 | speed 12 | torque 12 | power stage °C 8 | winding °C 8
//   register id = 0x7FF     motor u16 | 0x33 read, 0x55 write, 0xCC sample | register | value u32 or float
//
// There is no encoder for "here is zero" (seven FF, then FE): nothing in this program can send it.
#pragma once

#include <optional>

#include "protocol/can_frames.hpp"

namespace armsight {

inline constexpr std::uint32_t kMitRegisterId = 0x7FF;
inline constexpr double kMitMaxKp_Nm_rad = 500.0, kMitMaxKd_Nms_rad = 5.0;

/// What the ends of the codes stand for, ±; registers of the drive, and known to the robot file.
struct MitRanges {
  double position_rad = 12.5;
  double speed_rad_s = 30.0;
  double torque_Nm = 10.0;
};

/// torque = Kp (q - position) + Kd (speed - speed now) + torque, all at the output shaft.
struct MitCommand {
  double position_rad = 0.0, speed_rad_s = 0.0;
  double kp_Nm_rad = 0.0, kd_Nms_rad = 0.0;
  double torque_Nm = 0.0;
};

enum class MitState : std::uint8_t {
  kDisabled = 0x0, kEnabled = 0x1, kSensorFault = 0x5, kParameterFault = 0x6, kOverVoltage = 0x8, kUnderVoltage = 0x9,
  kOverCurrent = 0xA, kPowerStageHot = 0xB, kWindingHot = 0xC, kCommandsLost = 0xD, kOverload = 0xE
};
/// Neither enabled nor disabled.
constexpr bool is_mit_fault(MitState state) noexcept { return state > MitState::kEnabled; }
/// "commands lost: its time-out passed"; "unknown state" for others.
const char* to_text(MitState state) noexcept;

struct MitSample {
  MitState state = MitState::kDisabled;
  double position_rad = 0.0, speed_rad_s = 0.0, torque_Nm = 0.0;
  std::uint8_t power_stage_C = 0, winding_C = 0;
};

enum class MitOrder : std::uint8_t { kClearFault = 0xFB, kEnable = 0xFC, kDisable = 0xFD };

enum class MitRegister : std::uint8_t {
  kReplyId = 7, kMotorId = 8, kTimeout = 9, kControlMode = 10, kVersion = 14, kPositionRange = 21, kSpeedRange = 22,
  kTorqueRange = 23
};
inline constexpr std::uint32_t kMitMode = 1;              ///< of kControlMode; in any other a command is not answered
inline constexpr double kMitTimeoutUnit_s = 50e-6;        ///< of kTimeout; 0 there: never
/// Values beyond the ranges are held at their ends, never wrapped; not finite: 0. No command looks like an order.
CanFrame encode(const MitCommand& m, std::uint8_t motor, const MitRanges& ranges) noexcept;
CanFrame encode(MitOrder order, std::uint8_t motor) noexcept;
CanFrame encode_mit_read(MitRegister reg, std::uint8_t motor) noexcept;
CanFrame encode_mit_write(MitRegister reg, std::uint32_t value, std::uint8_t motor) noexcept;
/// Asks for a sample without commanding anything.
CanFrame encode_mit_refresh(std::uint8_t motor) noexcept;

/// nullopt: another identifier, another size, another motor.
std::optional<MitSample> decode_mit_sample(const CanFrame& f, std::uint8_t reply_id, std::uint8_t motor,
                                           const MitRanges& ranges) noexcept;
/// A sample may look like the answer to a register that was not asked for: give the one that was.
std::optional<std::uint32_t> decode_mit_answer(const CanFrame& f, std::uint8_t reply_id, std::uint8_t motor,
                                               MitRegister reg, bool is_write) noexcept;

// The drive's side: what simulators and tests need.
struct MitRequest {
  enum class Kind : std::uint8_t { kCommand, kOrder, kSetZero, kRead, kWrite, kRefresh } kind = Kind::kCommand;
  MitCommand command;
  MitOrder order = MitOrder::kDisable;
  std::uint8_t reg = 0;
  std::uint32_t value = 0;
};
std::optional<MitRequest> decode_mit_request(const CanFrame& f, std::uint8_t motor, const MitRanges& ranges) noexcept;
CanFrame encode(const MitSample& m, std::uint8_t reply_id, std::uint8_t motor, const MitRanges& ranges) noexcept;
CanFrame encode_mit_answer(std::uint8_t reg, std::uint32_t value, bool is_write, std::uint8_t reply_id,
                           std::uint8_t motor) noexcept;

}  // namespace armsight
