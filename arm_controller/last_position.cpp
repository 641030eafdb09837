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

LastPosition load_last_position(const std::filesystem::path& folder, const RobotConfig& robot) {
  std::ifstream in(folder / kFile);
  if (!in) return {};
  const std::string name = (folder / kFile).string();
  std::string magic;
  std::uint64_t hash = 0;
  if (!(in >> magic >> hash) || magic != kMagic) return {{}, name + ": damaged: must begin with " + kMagic};
  if (hash != model_hash(robot)) return {{}, name + ": is another robot's"};
  JointVector q(robot.arm.joint_count());
  for (double& angle : q)
    if (!(in >> angle) || !std::isfinite(angle))
      return {{}, name + ": damaged: must hold " + std::to_string(q.size()) + " angles"};
  return {q, {}};
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
