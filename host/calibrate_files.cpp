#include "host/calibrate_files.hpp"

#include <cstdio>
#include <ctime>
#include <utility>

#include "host/dataset.hpp"
#include "protocol/atomic_file.hpp"
#include "protocol/model_file.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRobotFile = "robot.yaml";
constexpr const char* kDatasetFile = "dataset.yaml";
constexpr const char* kSamplesFile = "samples.csv";
constexpr std::size_t kMatrixCells = 12;

std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, ",%.17g", value);
  return text;
}

// Poses as matrices: a rotation that went through a quaternion would come back with other last digits.
std::string matrix_header(const std::string& prefix) {
  std::string text;
  for (const char row : {'1', '2', '3'}) {
    for (const char column : {'1', '2', '3', '4'}) text += "," + prefix + "t" + row + column;
  }
  return text;
}

std::string matrix_cells(const Pose& T) {
  std::string text;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) text += exact(T.R(r, c));
    text += exact(T.p[r]);
  }
  return text;
}

std::string covariance_header() {
  std::string text;
  for (int r = 1; r <= 6; ++r) {
    for (int c = r; c <= 6; ++c) text += ",cov_" + std::to_string(r) + std::to_string(c);
  }
  return text;
}

/// ISO 8601, UTC, by the wall clock whatever the pace: the file tells people when it was made; nothing reads it back.
std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace

LookFiles::LookFiles(const fs::path& folder, const RobotConfig& robot, const fs::path& robot_file)
    : folder_(folder), robot_(read_text_file(robot_file)), dataset_(dataset_yaml_for_robot(robot, kRobotFile)),
      marker_(std::to_string(robot.hand_marker.id)) {
  rows_ = "time_s";
  for (const std::string& name : robot.joint_names) rows_ += "," + name;
  rows_ += ",marker" + matrix_header("") + matrix_header("second_") + covariance_header() + "\n";
}

void LookFiles::add(const LookSample& sample) {
  char time[40];
  std::snprintf(time, sizeof time, "%.9f", static_cast<double>(sample.arm_time_ns) * 1e-9);
  rows_ += time;
  for (const double q : sample.q_reading) rows_ += exact(q);
  rows_ += "," + marker_ + matrix_cells(sample.T_C_H);
  rows_ += sample.T_C_H_second ? matrix_cells(*sample.T_C_H_second) : std::string(kMatrixCells, ',');
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) rows_ += exact(sample.R_vision(r, c));
  }
  rows_ += "\n";
  if (!std::exchange(has_begun_, true)) return begin();
  write_file_atomically(folder_ / kSamplesFile, rows_, Durability::kUnsynced);
}

// The new set is whole before the last one gives up its name, and the last one stays beside it.
void LookFiles::begin() const {
  const fs::path made = folder_.string() + "-new", previous = folder_.string() + "-previous";
  fs::remove_all(made);
  fs::create_directories(made);
  write_file_atomically(made / kRobotFile, robot_, Durability::kUnsynced);
  write_file_atomically(made / kDatasetFile, dataset_, Durability::kUnsynced);
  write_file_atomically(made / kSamplesFile, rows_, Durability::kUnsynced);
  if (fs::exists(folder_)) {
    fs::remove_all(previous);
    fs::rename(folder_, previous);
  }
  fs::rename(made, folder_);
}

void save_calibration(const fs::path& file, const RobotConfig& robot, const LearnedModel& model,
                      const ArmCalibration& calibration) {
  ModelFile out;
  out.robot = robot.robot;
  out.model_hash = model_hash(robot);
  out.model = model;
  out.covariance = calibration.covariance;
  out.source = "calibration";
  out.date = date_now();
  out.report = {{"heldout_rms_mm", calibration.heldout.rms_mm}, {"heldout_rms_deg", calibration.heldout.rms_deg},
                {"training_rms_mm", calibration.training.rms_mm}, {"training_rms_deg", calibration.training.rms_deg},
                {"looks", static_cast<double>(calibration.looks.size())}};
  write_file_atomically(file, to_text(out));
}

}  // namespace armsight::host
