// What people are told about a DAMIAO drive: its faults and its lines of the self-check. Allocates.
#pragma once

#include <string>
#include <vector>

#include "arm_controller/fault.hpp"
#include "arm_controller/self_check.hpp"

namespace armsight::arm {

/// "" where the sentence is the same for every family.
std::string mit_fault_text(const Fault& fault);
std::vector<CheckLine> mit_lines_of(const NodeCheck& check);

}  // namespace armsight::arm
