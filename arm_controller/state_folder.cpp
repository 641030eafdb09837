#include "arm_controller/state_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "protocol/atomic_file.hpp"
#include "protocol/model_file.hpp"

namespace armsight::arm {
namespace {

std::filesystem::path model_path(const std::filesystem::path& folder) { return folder / "model.yaml"; }

}  // namespace

Descriptor hold_state_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw ConfigError("--state " + folder.string() + ": no folder can be made there: " + error.message());
  Descriptor held(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (held.get() < 0) throw ConfigError("--state " + folder.string() + ": cannot be opened: " + std::strerror(errno));
  if (::flock(held.get(), LOCK_EX | LOCK_NB) != 0)
    throw ConfigError("--state " + folder.string() + ": another arm_controller works there (" + std::strerror(errno) + ")");
  return held;
}

StartModel load_model_in_force(const std::filesystem::path& folder, const RobotConfig& robot) {
  const int joints = robot.arm.joint_count();
  if (!std::filesystem::exists(model_path(folder)))
    return {{0, robot.camera_hint_T_C_B, JointVector::Zero(joints)}, std::nullopt, ModelSource::kNominal};
  std::ifstream in(model_path(folder));
  std::stringstream text;
  text << in.rdbuf();
  if (!in) throw ConfigError(model_path(folder).string() + ": cannot be read");
  const ModelFile file =
      parse_model_file(text.str(), model_path(folder).string(), {robot.robot, model_hash(robot), joints});
  return {file.model, file.covariance, ModelSource::kLoaded};
}

void save_model_in_force(const std::filesystem::path& folder, const RobotConfig& robot, const ModelEvent& model) {
  ModelFile file;
  file.robot = robot.robot;
  file.model_hash = model_hash(robot);
  file.model = model.model;
  file.covariance = model.P;
  file.source = model.source == ModelSource::kFilter ? "filter" : "calibration";
  // A filter's revision waits for no disk: who saw it lost the link when the machine went down with it.
  const bool is_filters = model.source == ModelSource::kFilter;
  write_file_atomically(model_path(folder), to_text(file), is_filters ? Durability::kUnsynced : Durability::kSynced);
}

std::filesystem::path new_recording_file(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "ticks.mcap", previous = folder / "ticks-previous.mcap";
  std::error_code error;
  std::filesystem::rename(file, previous, error);
  const bool is_done = !error || error == std::errc::no_such_file_or_directory;
  if (!is_done) throw std::runtime_error(file.string() + ": cannot become " + previous.string() + ": " + error.message());
  return file;
}

std::filesystem::path new_black_box_file(const std::filesystem::path& folder, const FaultEvent& fault) {
  const std::string name = "blackbox-" + std::to_string(to_ns(fault.time) / 1'000'000) + "ms-fault" +
                           std::to_string(static_cast<int>(fault.fault.code));
  std::filesystem::path file = folder / (name + ".mcap");
  for (int i = 2; std::filesystem::exists(file); ++i) file = folder / (name + "-" + std::to_string(i) + ".mcap");
  return file;
}

}  // namespace armsight::arm
