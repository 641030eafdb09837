#include "arm_controller/fault.hpp"

#include <cstdio>

#include "protocol/can_frames.hpp"

namespace armsight::arm {
namespace {

std::string hex(std::uint32_t value, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%0*X", digits, value);
  return text;
}

std::string object(const Fault& f) { return hex(f.index, 4) + ":" + std::to_string(f.sub); }

std::string status_text(std::uint32_t detail) {
  const auto statusword = static_cast<std::uint16_t>(detail & 0xFFFF);
  return std::string(to_text(drive_state(statusword))) + ", last emergency " + hex(detail >> 16, 4);
}

}  // namespace

std::string fault_text(const Fault& f) {
  const std::string node = "node " + std::to_string(f.node);
  switch (f.code) {
    case FaultCode::kNone: return "no fault";
    case FaultCode::kBusLost: return "the CAN bus is gone";
    case FaultCode::kBusOff: return "the CAN interface is bus-off";
    case FaultCode::kNodeAbsent: return node + ": neither boot-up nor heartbeat nor answer";
    case FaultCode::kFeedbackMissing: return node + ": third TPDO1 missing in a row";
    case FaultCode::kHeartbeatLost: return node + ": no heartbeat for " + std::to_string(f.detail) + " ms";
    case FaultCode::kSdoTimeout: return node + ": no answer to " + object(f) + " within 100 ms, three times";
    case FaultCode::kSdoAborted: return node + ": " + object(f) + " refused: " + sdo_abort_text(f.detail);
    case FaultCode::kWrongIdentity:
      return node + ": " + object(f) + " is " + hex(f.detail, 8) + ", the configuration asks for " + hex(f.expected, 8);
    case FaultCode::kReadBackDiffers:
      return node + ": wrote " + hex(f.expected, 8) + " to " + object(f) + ", read back " + hex(f.detail, 8);
    case FaultCode::kNodeRestarted: return node + ": restarted while in use";
    case FaultCode::kSendFailed: return "set-points could not be sent in three cycles in a row";
    case FaultCode::kDriveFault: return node + ": drive fault, " + status_text(f.detail);
    case FaultCode::kEnableTimeout: return node + ": 200 ms without the next state on enabling, " + status_text(f.detail);
    case FaultCode::kTargetIgnored: return node + ": enabled but bit 12 says that the target is ignored";
    case FaultCode::kDriveLeftOperation: return node + ": left operation unasked, " + status_text(f.detail);
    case FaultCode::kFaultResetFailed: return node + ": the fault reset did not help, " + status_text(f.detail);
    case FaultCode::kEncoderStep: return node + ": the encoder stepped farther than the joint can move in a cycle";
    case FaultCode::kOutsideLimits:
      return node + ": position far outside the limits at power-on (an encoder off by a whole turn?)";
    case FaultCode::kCycleOverrun: return "ten cycles late in a row";
    case FaultCode::kNotFinite: return "a computed set-point was not finite";
    case FaultCode::kModelNotSaved: return "the model in force could not be saved";
  }
  return "unknown fault";
}

const char* fault_side(FaultCode code) {
  const int number = static_cast<int>(code);
  return number >= 300 ? "self" : number >= 200 ? "drive" : "bus";
}

}  // namespace armsight::arm
