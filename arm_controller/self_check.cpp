#include "arm_controller/self_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "arm_controller/mit_reports.hpp"
#include "shared/geometry.hpp"

namespace armsight::arm {
namespace {

template <typename... Args>
std::string format(const char* pattern, Args... args) {
  char text[200];
  std::snprintf(text, sizeof text, pattern, args...);
  return text;
}

bool is_refused_for(const NodeCheck& n, std::initializer_list<FaultCode> codes) {
  return n.fault.is_set() && std::find(codes.begin(), codes.end(), n.fault.code) != codes.end();
}

/// The RPDO's deadline stands among the PDO's parameters, but is a reaction.
bool is_mapping(ObjectAddress object) {
  return object.index >= 0x1400 && object.index < 0x1C00 && object != ObjectAddress{0x1400, 5};
}

CheckLine identity_line(const NodeCheck& n) {
  if (is_refused_for(n, {FaultCode::kNodeAbsent})) return {Verdict::kRefused, n.node, "identity: " + fault_text(n.fault)};
  const bool is_wrong = is_refused_for(n, {FaultCode::kWrongIdentity}) && n.fault.index != 0x608F;
  if (is_wrong || !n.is_identified)
    return {Verdict::kRefused, n.node, "identity: " + (n.fault.is_set() ? fault_text(n.fault) : std::string("not read"))};
  return {Verdict::kOk, n.node, format("identity: CiA 402, vendor 0x%08X, product 0x%08X, revision 0x%08X, serial %u, \"%s\"",
                                       n.vendor, n.product, n.revision, n.serial, n.name.data())};
}

CheckLine units_line(const NodeCheck& n) {
  if (is_refused_for(n, {FaultCode::kWrongIdentity}) && n.fault.index == 0x608F)
    return {Verdict::kRefused, n.node, "units: " + fault_text(n.fault)};
  const char* mode = n.mode == DriveMode::kCyclicVelocity    ? "cyclic velocity"
                     : n.mode == DriveMode::kProfilePosition ? "profile position"
                                                             : "cyclic position";
  const std::string homing = n.homing_method == 0 ? "" : format(", homing %d when first enabled", n.homing_method);
  return {Verdict::kOk, n.node, format("units: %.0f counts a turn, %s", n.counts_per_turn, mode) + homing};
}

std::string shortfall_text(const Shortfall& s) {
  const std::string object = format("0x%04X:%d wanted %u, ", s.object.index, s.object.sub, s.wanted);
  if (s.abort_code != 0) return object + "refused: " + sdo_abort_text(s.abort_code);
  return object + format("reads back %u", s.got);
}

/// One line for the mapping, one for the reactions; what is missing in either is told there.
CheckLine settings_line(const NodeCheck& n, bool of_mapping) {
  CheckLine line{Verdict::kOk, n.node, of_mapping ? "mapping: " : "reactions: "};
  std::string missing;
  for (std::size_t i = 0; i < n.shortfall_count; ++i) {
    if (is_mapping(n.shortfalls[i].object) != of_mapping) continue;
    missing += (missing.empty() ? "" : "; ") + shortfall_text(n.shortfalls[i]);
  }
  const bool is_here = is_mapping({n.fault.index, n.fault.sub}) == of_mapping && !is_refused_for(n, {FaultCode::kWrongIdentity});
  const bool is_of_settings = n.fault.index != 0 || n.fault.code == FaultCode::kNoSupervision;
  if (n.fault.is_set() && is_here && is_of_settings)
    return {Verdict::kRefused, n.node, line.text + fault_text(n.fault)};
  if (!n.is_mapped) return {Verdict::kRefused, n.node, line.text + "not reached"};
  if (!missing.empty()) line.verdict = Verdict::kDegraded;
  line.text += !missing.empty() ? missing
               : of_mapping     ? "written and read back"
                                : "quick stop on loss, hold powered, RPDO deadline, heartbeat watched: read back";
  return line;
}

CheckLine wrap_line(const WrapCheck& w, std::uint8_t node) {
  if (!w.is_known) return {w.verdict, node, format("position: %.2f deg, not compared: none was saved", w.now_rad / kDegree)};
  const char* rule = w.verdict == Verdict::kRefused ? ": about a whole turn" : "";
  return {w.verdict, node, format("position: %.2f deg, %.2f deg from where it was last seen%s", w.now_rad / kDegree,
                                  (w.now_rad - w.last_rad) / kDegree, rule)};
}

std::vector<CheckLine> canopen_lines_of(const NodeCheck& n) {
  std::vector<CheckLine> lines{identity_line(n)};
  if (worst_of(lines) == Verdict::kRefused) return lines;
  lines.push_back(units_line(n));
  if (worst_of(lines) == Verdict::kRefused) return lines;
  lines.push_back(settings_line(n, true));
  lines.push_back(settings_line(n, false));
  return lines;
}

/// wrap: of a joint, or nullptr.
std::vector<CheckLine> lines_of_node(const NodeCheck& n, const WrapCheck* wrap) {
  std::vector<CheckLine> lines = n.family == DriveFamily::kDamiao ? mit_lines_of(n) : canopen_lines_of(n);
  if (wrap != nullptr && n.is_ready) lines.push_back(wrap_line(*wrap, n.node));
  if (n.fault.is_set() && worst_of(lines) != Verdict::kRefused)
    lines.push_back({Verdict::kRefused, n.node, "reports: " + fault_text(n.fault)});
  return lines;
}

}  // namespace

const char* to_text(Verdict verdict) noexcept {
  return verdict == Verdict::kOk ? "ok" : verdict == Verdict::kDegraded ? "DEGRADED" : "REFUSED";
}

bool is_about_a_whole_turn(double moved_rad) noexcept {
  const double turns = std::round(moved_rad / (2.0 * std::numbers::pi));
  return turns != 0.0 && std::abs(moved_rad - turns * 2.0 * std::numbers::pi) < kWholeTurnSlack_rad;
}

std::vector<CheckLine> lines_of(const SelfCheck& check) {
  std::vector<CheckLine> lines;
  for (int i = 0; i < check.node_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool is_joint = i + 1 < check.node_count;
    for (const CheckLine& line : lines_of_node(check.nodes[k], is_joint ? &check.wraps[k] : nullptr)) lines.push_back(line);
  }
  return lines;
}

Verdict worst_of(const std::vector<CheckLine>& lines) {
  Verdict worst = Verdict::kOk;
  for (const CheckLine& line : lines) worst = std::max(worst, line.verdict);
  return worst;
}

std::string to_text(const std::vector<CheckLine>& lines) {
  std::string page = "arm_controller: self-check before power\n";
  for (const CheckLine& line : lines) page += format("  node %3d  %-8s  ", line.node, to_text(line.verdict)) + line.text + "\n";
  const Verdict worst = worst_of(lines);
  return page + "arm_controller: self-check: " + to_text(worst) +
         (worst == Verdict::kRefused ? ", the arm is not enabled\n" : "\n");
}

}  // namespace armsight::arm
