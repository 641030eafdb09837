#include "host/urdf_import.hpp"

#include <cmath>
#include <cstdio>

#include "host/robot_description.hpp"

namespace armsight::host {
namespace {

std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value + 0.0);  // no "-0"
  return text;
}

std::string list(const Vector3& v) { return "[" + exact(v.x()) + ", " + exact(v.y()) + ", " + exact(v.z()) + "]"; }

std::string frame(const Pose& T) { return "{xyz_m: " + list(T.p) + ", rpy_rad: " + list(to_rpy(T.R)) + "}"; }

std::string joint_row(const DescribedJoint& joint, const Pose& T_after, std::size_t number) {
  const bool has_limits = joint.min_rad < joint.max_rad;
  const double low = has_limits ? joint.min_rad : -M_PI, high = has_limits ? joint.max_rad : M_PI;
  const double speed = joint.max_speed_rad_s > 0.0 ? std::min(joint.max_speed_rad_s, 0.5) : 0.5;
  return "  - {name: " + joint.name + ",\n     frame: " + frame(T_after) + ",\n     min_rad: " + exact(low) +
         ", max_rad: " + exact(high) + ", max_speed_rad_s: " + exact(speed) +
         ", max_acceleration_rad_s2: 4, max_jerk_rad_s3: 80,\n     drive: {node: " + std::to_string(number) +
         ", counts_per_turn: 32768, sign: 1, zero_rad: 0, commissioned: false}}" +
         (has_limits ? "" : "   # no limits in the URDF: one turn") + "\n";
}

}  // namespace

std::string import_urdf(const std::filesystem::path& file, const std::string& base, const std::string& tip) {
  const DescribedChain described = read_urdf_chain(file, base, tip);
  const SerialChain chain = to_serial_chain(described);
  std::string text = "# Imported from " + file.filename().string() + ", links " + base + " to " + tip +
                     ". Every joint turns about z; frame is the fixed pose after its turn.\n"
                     "# A URDF does not know the drives, speeds kept low for a first run: "
                     "check node and counts_per_turn, then let host commission find sign, scale and zero.\n";
  text += "base_to_joint1: " + frame(chain.T_B_0) + "\njoints:\n";
  for (std::size_t i = 0; i < described.joints.size(); ++i) {
    text += joint_row(described.joints[i], chain.T_after[i], i + 1);
  }
  return text;
}

}  // namespace armsight::host
