// The chains of a dataset.yaml: joints written inline (URDF's words or DH rows), a URDF, an Armsight robot file, or
// given poses. The format is host/DATASET.md; mistakes are recorded with the value, none is thrown here.
#pragma once

#include <filesystem>

#include "host/chain_problem.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {

/// owner.key as {xyz_m, rpy_rad} or {xyz_m, quat_wxyz}; identity where it is left out.
Pose optional_pose(const YamlValue& owner, const char* key);

/// One entry of `chains`: adds the chain to the model, and its joints where another chain has not brought them.
void read_chain(const YamlValue& value, const std::filesystem::path& folder, ChainModel& model);

}  // namespace armsight::host
