#include "host/learn_files.hpp"

#include <cstdio>
#include <ctime>
#include <system_error>

#include "host/dataset.hpp"
#include "host/session_files.hpp"
#include "protocol/model_file.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

constexpr const char* kRobotFile = "robot.yaml";

std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, ",%.17g", value);
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

LookFiles::LookFiles(const std::filesystem::path& folder, const RobotConfig& robot, const std::filesystem::path& robot_file)
    : folder_(folder), T_H_M_(robot.arm.T_H_M), marker_id_(robot.hand_marker.id) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw ConfigError(folder_.string() + ": cannot be made: " + error.message());
  write_atomically(folder_ / kRobotFile, read_text_file(robot_file));
  write_atomically(folder_ / "dataset.yaml", dataset_yaml_for_robot(robot, kRobotFile));
  rows_ = "time_s";
  for (const std::string& name : robot.joint_names) rows_ += "," + name;
  rows_ += ",marker,x_m,y_m,z_m,qw,qx,qy,qz\n";
  write_atomically(folder_ / "samples.csv", rows_);
}

void LookFiles::add(const LookSample& sample) {
  char time[40];
  std::snprintf(time, sizeof time, "%.9f", static_cast<double>(sample.arm_time_ns) * 1e-9);
  rows_ += time;
  for (const double q : sample.q_reading) rows_ += exact(q);
  rows_ += "," + std::to_string(marker_id_);
  const Pose T_C_M = sample.T_C_H * T_H_M_;
  const Eigen::Quaterniond quat(T_C_M.R);
  for (const double value : {T_C_M.p.x(), T_C_M.p.y(), T_C_M.p.z(), quat.w(), quat.x(), quat.y(), quat.z()}) rows_ += exact(value);
  rows_ += "\n";
  write_atomically(folder_ / "samples.csv", rows_);
}

void save_calibration(const std::filesystem::path& file, const RobotConfig& robot, const LearnedModel& model,
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
  write_atomically(file, to_text(out));
}

}  // namespace armsight::host
