// The controller's state folder: model.yaml (the model in force), ticks.mcap, blackbox-*.mcap.
#pragma once

#include <filesystem>

#include "arm_controller/adaptation.hpp"
#include "protocol/descriptor.hpp"

namespace armsight::arm {

/// Creates the folder where needed and holds it while the descriptor lives: two controllers would overwrite each other's
/// model. Throws ConfigError with the reason.
[[nodiscard]] Descriptor hold_state_folder(const std::filesystem::path& folder);
/// The model in force, or the nominal one (camera where the hint says, no offsets, revision 0) where there is no file.
/// Throws ConfigError on a file that is damaged or of another robot: nothing is then overwritten.
StartModel load_model_in_force(const std::filesystem::path& folder, const RobotConfig& robot);
/// Atomic. Throws std::runtime_error.
void save_model_in_force(const std::filesystem::path& folder, const RobotConfig& robot, const ModelEvent& model);
/// Where the new ticks.mcap goes; the one before becomes ticks-previous.mcap. Throws std::runtime_error where it cannot.
std::filesystem::path new_recording_file(const std::filesystem::path& folder);
/// blackbox-12034ms-fault104.mcap; ms count from the start of the program, so where an earlier run had the same moment,
/// -2, -3 … follows.
std::filesystem::path new_black_box_file(const std::filesystem::path& folder, const FaultEvent& fault);

}  // namespace armsight::arm
