#include "arm_controller/last_position.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>

#include "protocol/atomic_file.hpp"

namespace armsight::arm {
namespace {

constexpr const char* kFile = "position.txt";
constexpr const char* kMagic = "armsight-position-1";

}  // namespace

std::optional<JointVector> load_last_position(const std::filesystem::path& folder, const RobotConfig& robot) {
  std::ifstream in(folder / kFile);
  std::string magic;
  std::uint64_t hash = 0;
  if (!(in >> magic >> hash) || magic != kMagic || hash != model_hash(robot)) return std::nullopt;
  JointVector q(robot.arm.joint_count());
  for (double& angle : q)
    if (!(in >> angle) || !std::isfinite(angle)) return std::nullopt;
  return q;
}

void save_last_position(const std::filesystem::path& folder, const RobotConfig& robot, const JointVector& q_reading_rad) {
  std::string text = std::string(kMagic) + " " + std::to_string(model_hash(robot));
  for (const double angle : q_reading_rad) {
    char number[32];
    std::snprintf(number, sizeof number, " %.9f", angle);
    text += number;
  }
  write_file_atomically(folder / kFile, text + "\n", Durability::kUnsynced);
}

}  // namespace armsight::arm
