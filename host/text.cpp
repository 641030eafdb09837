#include "host/text.hpp"

#include <cstdio>

namespace armsight::host {

const char* to_text(wire::Mode mode) {
  switch (mode) {
    case wire::MODE_BOOT: return "boot";
    case wire::MODE_BUS_DOWN: return "bus down";
    case wire::MODE_CONFIGURING: return "configuring";
    case wire::MODE_READY: return "ready (power off)";
    case wire::MODE_HOLD: return "hold";
    case wire::MODE_SERVO: return "servo";
    case wire::MODE_STOPPING: return "stopping";
    case wire::MODE_FAULT: return "fault";
    case wire::MODE_RECOVERING: return "recovering";
    default: return "unknown";
  }
}

const char* to_text(wire::FusionOutcome outcome) {
  switch (outcome) {
    case wire::FUSION_OUTCOME_FUSED: return "fused";
    case wire::FUSION_OUTCOME_FUSED_SECOND_SOLUTION: return "fused, second solution";
    case wire::FUSION_OUTCOME_REJECTED_BY_GATE: return "rejected by gate";
    case wire::FUSION_OUTCOME_ILL_CONDITIONED: return "ill-conditioned";
    case wire::FUSION_OUTCOME_NOT_FINITE: return "not finite";
    case wire::FUSION_OUTCOME_NO_JOINTS: return "outside the joint history";
    case wire::FUSION_OUTCOME_MOVING: return "arm was moving";
    case wire::FUSION_OUTCOME_IMPLAUSIBLE: return "model beyond reason, rolled back";
    default: return "unknown";
  }
}

const char* to_text(wire::GoalState state) {
  switch (state) {
    case wire::GOAL_STATE_MOVING: return "moving";
    case wire::GOAL_STATE_ARRIVED: return "arrived";
    case wire::GOAL_STATE_STOPPED: return "stopped";
    case wire::GOAL_STATE_REPLACED: return "replaced";
    default: return "unknown";
  }
}

std::string to_text(const wire::StopReport& report) {
  return std::to_string(report.code()) + " (" + report.side() + "): " + report.text();
}

double degrees(double rad) { return rad / kDegree; }

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string degrees_text(const JointVector& q_rad) {
  std::string text;
  for (const double q : q_rad) text += (text.empty() ? "" : " ") + fixed(degrees(q), 1);
  return text;
}

}  // namespace armsight::host
