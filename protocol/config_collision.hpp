// The robot file's `collision`: capsules on links, keep-out zones in the base, pairs of links held against each other.
#pragma once

#include <string>
#include <vector>

#include "protocol/strict_yaml.hpp"
#include "shared/collision.hpp"

namespace armsight {

struct CollisionConfig {
  CollisionModel model;                                   ///< empty where the file says nothing
  std::vector<std::string> capsules, half_spaces, boxes;  ///< names, in the model's order
};

/// Records violations in the file; what it answers then is not to be used.
CollisionConfig read_collision(const YamlValue& collision, int joint_count);

/// "hand comes within 3.1 mm of table (margin 5.0 mm)"; of a free place: "nearest: hand to table, 31.0 mm".
std::string to_text(const CollisionConfig& collision, const Clearance& nearest);

}  // namespace armsight
