// What the robot file says of drives: the keys `drive` of a joint and `hand`.
#pragma once

#include <set>

#include "protocol/config.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight {

/// taken: identifiers of nodes and of replies so far; they differ all over the arm.
/// farthest_rad: of the joint's limits.
DriveConfig read_drive(const YamlValue& drive, std::set<std::int64_t>& taken, double farthest_rad);
HandConfig read_hand(const YamlValue& hand, std::set<std::int64_t>& taken);

}  // namespace armsight
