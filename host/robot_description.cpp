#include "host/robot_description.hpp"

#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>

#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

/// A rotation that brings z onto the axis; the identity for z itself, so that plain descriptions stay plain.
Matrix3 z_onto(const Vector3& axis) {
  const Vector3 u = axis.normalized();
  const double c = u.z();
  if (c > 1.0 - 1e-15) return Matrix3::Identity();
  if (c < -1.0 + 1e-15) return Vector3(1.0, -1.0, -1.0).asDiagonal();
  const Vector3 v(-u.y(), u.x(), 0.0);  // z × u
  return Matrix3::Identity() + skew(v) + skew(v) * skew(v) / (1.0 + c);
}

Pose to_pose(const urdf::Pose& pose) {
  Eigen::Quaterniond quat(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z);
  return {quat.normalized().toRotationMatrix(), Vector3(pose.position.x, pose.position.y, pose.position.z)};
}

/// Joints from base to tip, fixed ones among them.
std::vector<urdf::JointConstSharedPtr> joints_between(const urdf::ModelInterface& model, const std::string& where,
                                                      const std::string& base, const std::string& tip) {
  for (const auto& name : {base, tip}) {
    if (!model.getLink(name)) throw ConfigError(where + ": link " + name + ": is not in this robot");
  }
  std::vector<urdf::JointConstSharedPtr> joints;
  for (auto link = model.getLink(tip); link->name != base; link = model.getLink(link->parent_joint->parent_link_name)) {
    if (!link->parent_joint) throw ConfigError(where + ": link " + tip + ": does not hang from link " + base);
    joints.push_back(link->parent_joint);
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

DescribedJoint to_described(const urdf::Joint& joint, const Pose& before, const std::string& where) {
  if (joint.type != urdf::Joint::REVOLUTE && joint.type != urdf::Joint::CONTINUOUS) {
    throw ConfigError(where + ": joint " + joint.name + ": must be revolute, continuous or fixed");
  }
  if (joint.mimic) throw ConfigError(where + ": joint " + joint.name + ": must not mimic another");
  DescribedJoint described;
  described.name = joint.name;
  described.origin = before * to_pose(joint.parent_to_joint_origin_transform);
  described.axis = Vector3(joint.axis.x, joint.axis.y, joint.axis.z);
  if (!(described.axis.norm() > 1e-9)) throw ConfigError(where + ": joint " + joint.name + ": axis must not be zero");
  if (joint.limits) {
    described.min_rad = joint.limits->lower;
    described.max_rad = joint.limits->upper;
    described.max_speed_rad_s = joint.limits->velocity;
  }
  return described;
}

}  // namespace

SerialChain to_serial_chain(const DescribedChain& described) {
  SerialChain chain;
  chain.joint_count = static_cast<int>(described.joints.size());
  Matrix3 undo = Matrix3::Identity();
  for (std::size_t i = 0; i < described.joints.size(); ++i) {
    const Matrix3 A = z_onto(described.joints[i].axis);
    const Pose fixed = Pose{undo, Vector3::Zero()} * described.joints[i].origin * Pose{A, Vector3::Zero()};
    (i == 0 ? chain.T_B_0 : chain.T_after[i - 1]) = fixed;
    undo = A.transpose();
  }
  if (!described.joints.empty())
    chain.T_after[described.joints.size() - 1] = Pose{undo, Vector3::Zero()} * described.tip;
  return chain;
}

Vector3 to_rpy(const Matrix3& R) {
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double yaw = cos_pitch > 1e-15 ? std::atan2(R(1, 0), R(0, 0)) : 0.0;  // at ±90° roll and yaw are one turn
  const double s = std::sin(yaw), c = std::cos(yaw);
  const double pitch = std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0));
  const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));  // of Rz(−yaw) R
  return {roll, pitch, yaw};
}

Matrix3 from_rpy(const Vector3& rpy_rad) {
  return (Eigen::AngleAxisd(rpy_rad.z(), Vector3::UnitZ()) * Eigen::AngleAxisd(rpy_rad.y(), Vector3::UnitY()) *
          Eigen::AngleAxisd(rpy_rad.x(), Vector3::UnitX()))
      .toRotationMatrix();
}

DescribedChain read_urdf_chain(const std::filesystem::path& file, const std::string& base, const std::string& tip) {
  const std::string where = file.string();
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(read_text_file(file));
  if (!model) throw ConfigError(where + ": is not a URDF robot");
  DescribedChain chain;
  for (const auto& joint : joints_between(*model, where, base, tip)) {
    if (joint->type == urdf::Joint::FIXED) {
      chain.tip = chain.tip * to_pose(joint->parent_to_joint_origin_transform);
      continue;
    }
    chain.joints.push_back(to_described(*joint, chain.tip, where));
    chain.tip = {};
  }
  const auto count = chain.joints.size();
  if (count < 1 || count > static_cast<std::size_t>(kMaxJoints)) {
    throw ConfigError(where + ": " + base + " to " + tip + " = " + std::to_string(count) + " joints: must be 1 to " +
                      std::to_string(kMaxJoints));
  }
  return chain;
}

}  // namespace armsight::host
