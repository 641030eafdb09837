// Words for people: modes, outcomes, angles. The only place where the host turns radians into degrees for a line.
#pragma once

#include <string>

#include "protocol/arm_link.pb.h"
#include "shared/arm_model.hpp"

namespace armsight::host {

const char* to_text(wire::Mode mode);
const char* to_text(wire::FusionOutcome outcome);
const char* to_text(wire::GoalState state);
/// "401 (link): the commander was silent longer than its lease, last heard 204.1 ms ago".
std::string to_text(const wire::StopReport& report);
/// "12.3 -4.0 0.1" in degrees.
std::string degrees_text(const JointVector& q_rad);
double degrees(double rad);
std::string fixed(double value, int decimals);

}  // namespace armsight::host
