// What the robot file says of a joint's link and spring: the keys `link: {mass_kg, com_m}` and
// `spring: {law, k_Nm, a_per_rad, preset_rad, max_deflection_rad}`, both optional.
#pragma once

#include "protocol/strict_yaml.hpp"
#include "shared/soft_joints.hpp"

namespace armsight {

/// Without the keys: no mass, a stiff joint.
LinkMass read_link_mass(const YamlValue& joint);
Spring read_spring(const YamlValue& joint);

}  // namespace armsight
