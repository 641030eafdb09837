// What can go wrong while running, numbered and latched: only an explicit command clears a fault.
// Each number has one paragraph in README.md (cause, what the arm does, what to do).
#pragma once

#include <cstdint>
#include <string>

namespace armsight::arm {

enum class FaultCode : std::uint16_t {
  kNone = 0,
  // bus
  kBusLost = 101,
  kBusOff = 102,
  kNodeAbsent = 103,
  kFeedbackMissing = 104,
  kHeartbeatLost = 105,
  kSdoTimeout = 106,
  kSdoAborted = 107,
  kWrongIdentity = 108,
  kReadBackDiffers = 109,
  kNodeRestarted = 110,
  kSendFailed = 111,
  // drive
  kDriveFault = 201,
  kEnableTimeout = 202,
  kTargetIgnored = 203,
  kDriveLeftOperation = 204,
  kFaultResetFailed = 205,
  kEncoderStep = 206,
  kOutsideLimits = 207,
  // self
  kCycleOverrun = 301,
  kNotFinite = 302,
  kModelNotSaved = 303,
};

/// Evidence beside the number. What `detail` is depends on the code: abort code, statusword, value read.
struct Fault {
  FaultCode code = FaultCode::kNone;
  std::uint8_t node = 0;    ///< CAN node, 0: none in particular
  std::uint16_t index = 0;  ///< object, where one is meant
  std::uint8_t sub = 0;
  std::uint32_t detail = 0;
  std::uint32_t expected = 0;

  bool is_set() const { return code != FaultCode::kNone; }
};

/// One sentence for people: what, where, which rule. Not for the tick (allocates).
std::string fault_text(const Fault& fault);
/// Whose side it is: "bus", "drive", "self".
const char* fault_side(FaultCode code);

}  // namespace armsight::arm
