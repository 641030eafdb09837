// STATE/position.txt: where the joints were last seen, so that an encoder that lost a turn over a power-down is noticed.
// Readings in rad, with the model hash of the robot file they belong to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "protocol/config.hpp"

namespace armsight::arm {

struct LastPosition {
  std::optional<JointVector> q_reading_rad;
  std::string why;  ///< there is none: empty where no file is, else what is wrong with it
};
/// The self-check says that nothing can be compared where there is none. A damaged file refuses nothing: it is not synced.
LastPosition load_last_position(const std::filesystem::path& folder, const RobotConfig& robot);
/// Atomic, not synced: written every second, and a model that is being saved must not wait behind it.
/// Throws std::runtime_error.
void save_last_position(const std::filesystem::path& folder, const RobotConfig& robot, const JointVector& q_reading_rad);

}  // namespace armsight::arm
