#include "host/dataset_chains.hpp"

#include <cmath>

#include "host/robot_description.hpp"
#include "protocol/config.hpp"
#include "protocol/config_values.hpp"

namespace armsight::host {
namespace {

constexpr double kFarthest_m = 100.0;  // nothing we calibrate is larger

/// {xyz_m, rpy_rad} or {xyz_m, quat_wxyz}.
Pose read_pose_or_frame(const YamlValue& value) {
  const YamlValue quat = value.optional_key("quat_wxyz");
  if (!quat.exists()) return read_frame(value);
  const std::vector<double> q = quat.numbers(4, -1.001, 1.001);
  const Pose position{Matrix3::Identity(), read_vector(value.key("xyz_m"), kFarthest_m)};
  if (q.size() != 4) return position;
  const Eigen::Quaterniond quat_A_B(q[0], q[1], q[2], q[3]);
  if (std::abs(quat_A_B.norm() - 1.0) > 1e-3) {
    quat.refuse("must have norm 1");
    return position;
  }
  return {quat_A_B.normalized().toRotationMatrix(), position.p};
}

int joint_index(ChainModel& model, const std::string& name) {
  for (std::size_t j = 0; j < model.offsets.size(); ++j) {
    if (model.offsets[j].name == name) return static_cast<int>(j);
  }
  model.offsets.push_back({name, 0.0, Freedom::kFixed, 0.0, 0.0});
  return static_cast<int>(model.offsets.size()) - 1;
}

/// Joints with xyz_m, rpy_rad, axis (URDF's own words), or with dh rows.
void read_inline_chain(const YamlValue& value, ProblemChain& chain, std::vector<std::string>& names) {
  const auto joints = value.key("joints").list(1, kMaxJoints);
  const Pose base = optional_pose(value, "base"), tip = optional_pose(value, "tip");
  DescribedChain described;
  std::size_t dh_rows = 0;
  chain.chain.joint_count = static_cast<int>(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    names.push_back(joints[i].key("name").text());
    const YamlValue dh = joints[i].optional_key("dh");
    if (dh.exists()) {
      ++dh_rows;
      chain.chain.T_after[i] = dh_transform({dh.key("a_m").number(-5, 5), dh.key("alpha_rad").number(-7, 7),
                                             dh.key("d_m").number(-5, 5), dh.key("theta_rad").number(-7, 7)});
      continue;
    }
    DescribedJoint joint;
    joint.origin = read_frame(joints[i]);
    const YamlValue axis = joints[i].optional_key("axis");
    if (axis.exists()) joint.axis = read_vector(axis, 1.001);
    if (axis.exists() && joint.axis.norm() < 0.5) axis.refuse("must be a direction of length 1");
    described.joints.push_back(joint);
  }
  described.tip = tip;
  if (dh_rows > 0 && dh_rows < joints.size()) value.refuse("must describe all its joints by dh, or none");
  if (joints.empty()) return;
  if (dh_rows == 0) chain.chain = to_serial_chain(described);
  if (dh_rows == joints.size()) chain.chain.T_after[joints.size() - 1] = chain.chain.T_after[joints.size() - 1] * tip;
  chain.chain.T_B_0 = base * chain.chain.T_B_0;
}

void read_urdf(const YamlValue& value, const std::filesystem::path& folder, ProblemChain& chain,
               std::vector<std::string>& names) {
  const YamlValue file = value.key("file");
  const std::string name = file.text(), base = value.key("base").text(), tip = value.key("tip").text();
  if (name.empty() || base.empty() || tip.empty()) return;
  try {
    const DescribedChain described = read_urdf_chain(folder / name, base, tip);
    chain.chain = to_serial_chain(described);
    for (const auto& joint : described.joints) names.push_back(joint.name);
  } catch (const ConfigError& error) {
    file.refuse(error.what());
  }
}

void read_robot_file(const YamlValue& value, const std::filesystem::path& folder, ProblemChain& chain,
                     std::vector<std::string>& names) {
  const std::string name = value.text();
  if (name.empty()) return;
  try {
    const RobotConfig robot = load_robot(folder / name);
    chain.chain = robot.arm.chain;
    names = robot.joint_names;
  } catch (const ConfigError& error) {
    value.refuse(error.what());
  }
}

}  // namespace

Pose optional_pose(const YamlValue& owner, const char* key) {
  const YamlValue value = owner.optional_key(key);
  return value.exists() ? read_pose_or_frame(value) : Pose{};
}

void read_chain(const YamlValue& value, const std::filesystem::path& folder, ChainModel& model) {
  ProblemChain chain;
  const YamlValue name = value.key("name");
  chain.name = name.text();
  for (const auto& other : model.chains) {
    if (other.name == chain.name) name.refuse("name is already taken");
  }
  if (chain.name == "root") name.refuse("is the word for the chains' common start");
  std::vector<std::string> joints;
  const YamlValue given = value.optional_key("given"), urdf = value.optional_key("urdf"),
                  robot_file = value.optional_key("robot_file");
  if (given.exists()) {
    chain.is_given = given.boolean();
    if (!chain.is_given) given.refuse("must be true, or leave it out");
  } else if (urdf.exists()) {
    read_urdf(urdf, folder, chain, joints);
  } else if (robot_file.exists()) {
    read_robot_file(robot_file, folder, chain, joints);
  } else {
    read_inline_chain(value, chain, joints);
  }
  for (const auto& joint : joints) chain.joints.push_back(joint_index(model, joint));
  model.chains.push_back(chain);
}

}  // namespace armsight::host
