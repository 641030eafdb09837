#include "arm_controller/fault.hpp"

#include <cstdio>

#include "arm_controller/emergency.hpp"
#include "arm_controller/mit_reports.hpp"
#include "protocol/can_frames.hpp"
#include "shared/geometry.hpp"

namespace armsight::arm {
namespace {

std::string hex(std::uint32_t value, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%0*X", digits, value);
  return text;
}

std::string object(const Fault& f) { return hex(f.index, 4) + ":" + std::to_string(f.sub); }

std::string status_text(const Fault& f) {
  const auto statusword = static_cast<std::uint16_t>(f.detail & 0xFFFF);
  const auto code = static_cast<std::uint16_t>(f.detail >> 16);
  const std::string drive = std::string(to_text(drive_state(statusword))) + " (statusword " + hex(statusword, 4) + ")";
  if (code == 0) return drive + ", no emergency message";
  return drive + ", last emergency " + hex(code, 4) + ": " + emergency_text(code) + " (error register: " +
         error_register_text(static_cast<std::uint8_t>(f.expected)) + ")";
}

std::string figure(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.1f %s", value, unit);
  return text;
}

std::string last_seen(const Fault& f, const char* what) {
  if (f.age_ns < 0) return std::string(", ") + what + " never";
  return std::string(", ") + what + " " + figure(1e-6 * static_cast<double>(f.age_ns), "ms ago");
}

std::string bus_number(const Fault& f) { return f.bus < 0 ? "" : " " + std::to_string(f.bus); }

/// Numbers of the robot file's lists, from 1; the tick knows no names.
std::string obstacle_text(const Fault& f) {
  const char* const kinds[] = {"nothing", "capsule ", "half-space ", "box "};
  return kinds[f.detail & 3] + std::to_string(f.expected);
}

std::string moved(const Fault& f) { return figure(f.moved_rad / kDegree, "deg"); }

}  // namespace

std::string fault_text(const Fault& f) {
  if (const std::string text = mit_fault_text(f); f.family == DriveFamily::kDamiao && !text.empty()) return text;
  const std::string node = "node " + std::to_string(f.node);
  switch (f.code) {
    case FaultCode::kNone: return "no fault";
    case FaultCode::kBusLost: return "the CAN bus" + bus_number(f) + " is gone";
    case FaultCode::kBusOff: return "the CAN interface" + (f.bus < 0 ? "" : " of bus" + bus_number(f)) + " is bus-off";
    case FaultCode::kNodeAbsent: return node + ": neither boot-up nor heartbeat nor answer in 3 s";
    case FaultCode::kFeedbackMissing: return node + ": third TPDO1 in a row missing" + last_seen(f, "last seen");
    case FaultCode::kHeartbeatLost:
      return node + ": no heartbeat for " + std::to_string(f.detail) + " ms" + last_seen(f, "last heard");
    case FaultCode::kSdoTimeout: return node + ": no answer to " + object(f) + " within 100 ms, three times";
    case FaultCode::kSdoAborted: return node + ": " + object(f) + " refused: " + sdo_abort_text(f.detail) + " (" + hex(f.detail, 8) + ")";
    case FaultCode::kWrongIdentity:
      return node + ": " + object(f) + " is " + hex(f.detail, 8) + ", the configuration asks for " + hex(f.expected, 8);
    case FaultCode::kReadBackDiffers:
      return node + ": wrote " + hex(f.expected, 8) + " to " + object(f) + ", read back " + hex(f.detail, 8);
    case FaultCode::kNodeRestarted: return node + ": restarted or left the operational state while in use";
    case FaultCode::kSendFailed: return "set-points could not be sent" + (f.bus < 0 ? "" : " on bus" + bus_number(f)) + " in three cycles in a row";
    case FaultCode::kNoSupervision:
      return node + ": has neither RPDO deadline (0x1400:5) nor heartbeat consumer (0x1016): it would not notice our death";
    case FaultCode::kEmergencyStorm:
      return node + ": " + std::to_string(f.detail & 0xFFFF) + " emergency messages within a second, the last " + hex(f.detail >> 16, 4) +
             ": " + emergency_text(static_cast<std::uint16_t>(f.detail >> 16));
    case FaultCode::kDriveFault: return node + ": drive fault, " + status_text(f);
    case FaultCode::kEnableTimeout: return node + ": 200 ms without the next state on enabling, " + status_text(f);
    case FaultCode::kTargetIgnored: return node + ": enabled but bit 12 says that the target is ignored";
    case FaultCode::kDriveLeftOperation: return node + ": left operation unasked, " + status_text(f);
    case FaultCode::kFaultResetFailed: return node + ": the fault reset did not help, " + status_text(f);
    case FaultCode::kEncoderStep: return node + ": the encoder stepped by " + moved(f) + ", farther than the joint can move in a cycle";
    case FaultCode::kOutsideLimits:
      return node + ": position far outside the limits at power-on (an encoder off by a whole turn?)";
    case FaultCode::kWholeTurn:
      return node + ": stands " + moved(f) + " from where it was last seen, about a whole turn: the encoder lost its turns";
    case FaultCode::kHomingFailed: return node + ": homing did not end, " + status_text(f);
    case FaultCode::kEncoderFrozen: return node + ": the encoder stands still while its set-point moved by " + moved(f);
    case FaultCode::kTurnUnknown:
      return node + ": its encoder knows where it is within a turn only; two turns lie inside the limits, and where it was last seen "
                    "is not known";
    case FaultCode::kCycleOverrun: return "ten cycles late in a row";
    case FaultCode::kNotFinite: return "a computed set-point was not finite";
    case FaultCode::kModelNotSaved: return "the model in force could not be saved";
    case FaultCode::kLeaseSilent: return std::string(stop_text(f.code)) + last_seen(f, "last heard");
    case FaultCode::kTooNear:
      return std::string(stop_text(f.code)) + ": capsule " + std::to_string(f.sub) + " to " + obstacle_text(f) + ", " +
             figure(1e3 * f.value, "mm") + " (margin " + figure(1e3 * f.limit, "mm") + ")";
    case FaultCode::kContact:
      return "joint " + std::to_string(f.sub) + ": " + stop_text(f.code) + ": " +
             (f.detail == 0
                  ? "following error " + figure(f.value / kDegree, "deg") + ", limit " +
                        figure(f.limit / kDegree, "deg")
                  : "torque " + figure(f.value, "N m") + " beside what holds the arm, limit " + figure(f.limit, "N m"));
    case FaultCode::kGoalGivenUp:
    case FaultCode::kConnectionClosed:
    case FaultCode::kLeaseReleased:
    case FaultCode::kHostLeft:
    case FaultCode::kStopAsked:
    case FaultCode::kHoldAsked: return stop_text(f.code);
  }
  return "unknown fault";
}

Fault too_near_fault(const Clearance& nearest, double margin_m) noexcept {
  Fault fault{FaultCode::kTooNear};
  fault.sub = static_cast<std::uint8_t>(nearest.capsule + 1);
  fault.detail = static_cast<std::uint32_t>(nearest.obstacle);
  fault.expected = nearest.other + 1u;
  fault.value = nearest.distance_m;
  fault.limit = margin_m;
  return fault;
}

Clearance clearance_of(const Fault& f) noexcept {
  return {f.value, static_cast<std::uint8_t>(f.sub - 1), static_cast<std::uint8_t>(f.expected - 1),
          static_cast<Obstacle>(f.detail)};
}

const char* fault_side(FaultCode code) noexcept {
  switch (static_cast<int>(code) / 100) {
    case 1: return "bus";
    case 2: return "drive";
    case 3: return "self";
    case 4: return "link";
    case 5: return "host";
    case 6: return "operator";
    default: return "none";
  }
}

const char* stop_text(FaultCode code) noexcept {
  switch (code) {
    case FaultCode::kGoalGivenUp: return "the arm did not come to rest within the tolerance";
    case FaultCode::kTooNear: return "stopped before coming too near";
    case FaultCode::kContact: return "stopped by contact";
    case FaultCode::kLeaseSilent: return "the commander was silent longer than its lease";
    case FaultCode::kConnectionClosed: return "the commander's connection closed";
    case FaultCode::kLeaseReleased: return "the commander released its lease";
    case FaultCode::kHostLeft: return "the commander left";
    case FaultCode::kStopAsked: return "stop was asked for";
    case FaultCode::kHoldAsked: return "hold was asked for";
    default: return "fault";
  }
}

}  // namespace armsight::arm
