#include "tools/sim/truth_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "shared/kinematics.hpp"

namespace armsight::sim {

namespace {

using nlohmann::json;

json to_json(const Pose& T) {
  const Eigen::Quaterniond quat(T.R);
  return {{"p_m", {T.p.x(), T.p.y(), T.p.z()}}, {"q_wxyz", {quat.w(), quat.x(), quat.y(), quat.z()}}};
}

json to_json(const JointVector& q) { return std::vector<double>(q.data(), q.data() + q.size()); }

json to_json(const SerialChain& chain) {
  json after = json::array();
  for (int i = 0; i < chain.joint_count; ++i) after.push_back(to_json(chain.T_after[static_cast<std::size_t>(i)]));
  return {{"T_B_0", to_json(chain.T_B_0)}, {"T_after", after}};
}

json model_to_json(const Truth& truth) { return {{"T_C_B", to_json(truth.T_C_B)}, {"beta_rad", to_json(truth.beta)}}; }

json grasps_to_json(const std::vector<GraspRecord>& grasps, const ToArmClock& to_arm) {
  json all = json::array();
  for (const GraspRecord& grasp : grasps)
    all.push_back({{"arm_time_ns", to_arm(grasp.time)},
                   {"held", grasp.is_held},
                   {"error_m", grasp.error_m},
                   {"error_rad", grasp.error_rad}});
  return all;
}

std::string header(int joints) {
  std::string text = "arm_time_ns";
  for (const char* name : {",q_true_", ",q_reading_"})
    for (int i = 1; i <= joints; ++i) text += name + std::to_string(i);
  return text + ",px,py,pz,qw,qx,qy,qz\n";
}

void append(std::string& text, double value) {
  char digits[32];
  text.append(digits, static_cast<std::size_t>(std::snprintf(digits, sizeof digits, ",%.9g", value)));
}

std::string to_csv(const TraceRow& row, const SerialChain& chain, const ToArmClock& to_arm) {
  std::string text = std::to_string(to_arm(row.time));
  for (const JointVector* q : {&row.q_true, &row.q_reading})
    for (const double value : *q) append(text, value);
  const Pose T_B_H = forward_kinematics(chain, row.q_true);
  const Eigen::Quaterniond quat(T_B_H.R);
  for (const double value : {T_B_H.p.x(), T_B_H.p.y(), T_B_H.p.z(), quat.w(), quat.x(), quat.y(), quat.z()})
    append(text, value);
  return text + "\n";
}

void require(std::ostream& out, const std::filesystem::path& file) {
  out.flush();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace

void write_truth(const World& world, const std::string& file, const ToArmClock& to_arm, Time end) {
  const std::filesystem::path path = file;
  const std::filesystem::path trace = std::filesystem::path(path).replace_extension(".csv");
  const Truth& before = world.truth_before();
  const Truth& after = world.plant().truth();
  json all{{"seed", before.seed}, {"noise", to_text(before.noise)}};
  all["arm"] = to_json(before.chain);
  all["T_H_M"] = to_json(before.T_H_M);
  all["before"] = model_to_json(before);
  all["after"] = model_to_json(after);
  all["after"]["arm_time_ns"] = to_arm(world.drift_time().value_or(end));
  all["T_B_O"] = to_json(before.T_B_O);
  all["grasps"] = grasps_to_json(world.plant().grasps(), to_arm);
  all["trace"] = trace.filename().string();
  all["trace_is_cut"] = world.trace_is_cut();
  std::ofstream json_out(path);
  json_out << all.dump(1) << "\n";
  require(json_out, path);
  std::ofstream csv(trace);
  csv << header(before.chain.joint_count);
  for (const TraceRow& row : world.trace()) csv << to_csv(row, before.chain, to_arm);
  require(csv, trace);
}

}  // namespace armsight::sim
