#include "arm_controller/mit_reports.hpp"

#include <bit>
#include <cstdio>

#include "protocol/mit_frames.hpp"

namespace armsight::arm {
namespace {

bool is_range(MitRegister reg) {
  return reg == MitRegister::kPositionRange || reg == MitRegister::kSpeedRange || reg == MitRegister::kTorqueRange;
}

const char* register_name(MitRegister reg) {
  switch (reg) {
    case MitRegister::kReplyId: return "reply id";
    case MitRegister::kMotorId: return "motor id";
    case MitRegister::kTimeout: return "time-out";
    case MitRegister::kControlMode: return "control mode";
    case MitRegister::kVersion: return "version";
    case MitRegister::kPositionRange: return "position range";
    case MitRegister::kSpeedRange: return "speed range";
    case MitRegister::kTorqueRange: return "torque range";
  }
  return "unknown";
}

std::string register_text(const Fault& f) {
  return "register " + std::to_string(f.index) + " (" + register_name(static_cast<MitRegister>(f.index)) + ")";
}

std::string value_text(const Fault& f, std::uint32_t value) {
  if (!is_range(static_cast<MitRegister>(f.index))) return std::to_string(value);
  char text[32];
  std::snprintf(text, sizeof text, "%g", static_cast<double>(std::bit_cast<float>(value)));
  return text;
}

std::string ago(const Fault& f) {
  if (f.age_ns < 0) return ", last seen never";
  char text[48];
  std::snprintf(text, sizeof text, ", last seen %.1f ms ago", 1e-6 * static_cast<double>(f.age_ns));
  return text;
}

std::string state_text(const Fault& f) { return to_text(static_cast<MitState>(f.detail)); }

}  // namespace

std::string mit_fault_text(const Fault& f) {
  const std::string motor = "motor " + std::to_string(f.node) + ": ";
  switch (f.code) {
    case FaultCode::kNodeAbsent: return motor + "no answer to any register in 3 s";
    case FaultCode::kFeedbackMissing: return motor + "third sample in a row missing" + ago(f);
    case FaultCode::kSdoTimeout: return motor + "no answer to " + register_text(f) + " within 100 ms, three times";
    case FaultCode::kWrongIdentity:
      return motor + register_text(f) + " is " + value_text(f, f.detail) + ", the configuration asks for " +
             value_text(f, f.expected);
    case FaultCode::kReadBackDiffers:
      return motor + "wrote " + value_text(f, f.expected) + " to " + register_text(f) + ", read back " +
             value_text(f, f.detail);
    case FaultCode::kNoSupervision:
      return motor + "its time-out (register 9) stays off: it would follow its last command for ever";
    case FaultCode::kDriveFault: return motor + "drive fault, " + state_text(f);
    case FaultCode::kEnableTimeout: return motor + "200 ms without being enabled, " + state_text(f);
    case FaultCode::kDriveLeftOperation: return motor + "left operation unasked, " + state_text(f);
    case FaultCode::kFaultResetFailed: return motor + "the fault reset did not help, " + state_text(f);
    default: return "";
  }
}

std::vector<CheckLine> mit_lines_of(const NodeCheck& n) {
  const auto line = [&n](Verdict verdict, const std::string& text) { return CheckLine{verdict, n.node, text}; };
  const std::string refused = n.fault.is_set() ? fault_text(n.fault) : std::string("not reached");
  if (!n.is_identified) return {line(Verdict::kRefused, "identity: " + refused)};
  std::vector<CheckLine> lines{line(Verdict::kOk, "identity: DAMIAO, version " + std::to_string(n.mit.version))};
  if (!n.is_mapped) {
    lines.push_back(line(Verdict::kRefused, "registers: " + refused));
    return lines;
  }
  const bool was_set = n.mit.mode_found != kMitMode;
  lines.push_back(line(was_set ? Verdict::kDegraded : Verdict::kOk,
                       was_set ? "registers: control mode was " + std::to_string(n.mit.mode_found) +
                                     ", in which it answers no command; now MIT, until its power goes"
                               : std::string("registers: control mode MIT, ranges as configured")));
  char text[120];
  std::snprintf(text, sizeof text, "reactions: lets go %.1f ms after the last command: no quick stop, no hold",
                1e3 * kMitTimeoutUnit_s * n.mit.timeout_units);
  lines.push_back(line(Verdict::kDegraded, text));
  if (n.mit.turns != 0)
    lines.push_back(line(Verdict::kDegraded, "position: woke up " + std::to_string(-n.mit.turns) + " turn beside, by the limits"));
  return lines;
}

}  // namespace armsight::arm
