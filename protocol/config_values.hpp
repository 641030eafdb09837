// Poses, vectors and marker names as our YAML files write them.
#pragma once

#include "protocol/strict_yaml.hpp"
#include "shared/geometry.hpp"

namespace armsight {

/// [x, y, z], each within ±max.
Vector3 read_vector(const YamlValue& value, double max);
/// {xyz_m, rpy_rad}: fixed-axis roll, pitch, yaw as URDF has them, R = Rz(yaw) Ry(pitch) Rx(roll).
Pose read_frame(const YamlValue& value);
/// The keys position_m and rotation_rows of a mapping. The rows must be a rotation to 1e-6; the nearest exact one is
/// taken.
Pose read_pose(const YamlValue& value);
/// Markers in the ArUco dictionary of that name, 0 for a name that is none.
int marker_dictionary_size(std::string_view dictionary);

}  // namespace armsight
