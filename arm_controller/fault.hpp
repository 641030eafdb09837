// Why the arm stops, numbered: what went wrong (below 400: latched, only an explicit command clears it), and what
// somebody asked for or failed to do (from 400 on: the arm stops and holds). Each number has one paragraph in README.md.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/drive_family.hpp"
#include "shared/collision.hpp"

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
  kNoSupervision = 112,
  kEmergencyStorm = 113,
  // drive
  kDriveFault = 201,
  kEnableTimeout = 202,
  kTargetIgnored = 203,
  kDriveLeftOperation = 204,
  kFaultResetFailed = 205,
  kEncoderStep = 206,
  kOutsideLimits = 207,
  kWholeTurn = 208,
  kHomingFailed = 209,
  kEncoderFrozen = 210,
  kTurnUnknown = 211,
  // self
  kCycleOverrun = 301,
  kNotFinite = 302,
  kModelNotSaved = 303,
  kGoalGivenUp = 304,
  kTooNear = 305,
  kContact = 306,
  // link: nothing is heard any more
  kLeaseSilent = 401,
  kConnectionClosed = 402,
  // host: it said so
  kLeaseReleased = 501,
  kHostLeft = 502,
  // operator
  kStopAsked = 601,
  kHoldAsked = 602,
};

/// Evidence beside the number. What `detail` is depends on the code: abort code, statusword and emergency code, value read.
struct Fault {
  FaultCode code = FaultCode::kNone;
  std::uint8_t node = 0;    ///< CAN node, 0: none in particular
  std::uint16_t index = 0;  ///< object, where one is meant
  std::uint8_t sub = 0;
  std::uint32_t detail = 0;
  std::uint32_t expected = 0;   ///< value wanted; after an emergency: the error register
  std::int64_t age_ns = -1;     ///< since the last sign of life; -1: says nothing
  double moved_rad = 0.0;       ///< what a joint seems to have moved
  DriveFamily family = DriveFamily::kCanopen;  ///< of the node
  std::int8_t bus = -1;         ///< of several buses; -1: there is only one, or none is meant
  double value = 0.0, limit = 0.0;  ///< of a quantity that the text names

  bool is_set() const { return code != FaultCode::kNone; }
};

/// One sentence for people: what, where, which rule. Not for the tick (allocates).
std::string fault_text(const Fault& fault);
/// Of kTooNear and back: the pair in `sub`, `detail`, `expected`, the distance in `value`.
Fault too_near_fault(const Clearance& nearest, double margin_m) noexcept;
Clearance clearance_of(const Fault& too_near) noexcept;
/// Whose side it is: "bus", "drive", "self", "link", "host", "operator".
const char* fault_side(FaultCode code) noexcept;
/// A stop that was asked for, or that a lost lease made: it needs no clearing.
inline bool is_plain_stop(FaultCode code) noexcept { return code >= FaultCode::kGoalGivenUp; }
/// The cause without its evidence; for the tick (allocates nothing).
const char* stop_text(FaultCode code) noexcept;

}  // namespace armsight::arm
