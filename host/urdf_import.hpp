// `host robot import`: the joints section of a robot file from a URDF. What a URDF does not know (drives, hand,
// marker, gravity) stays to be filled in by people; the text says where.
#pragma once

#include <filesystem>
#include <string>

namespace armsight::host {

/// YAML text: base_to_joint1 and joints with frame rows, full precision. Throws ConfigError.
std::string import_urdf(const std::filesystem::path& file, const std::string& base, const std::string& tip);

}  // namespace armsight::host
