// Arms of six and seven joints come from a URDF into a robot file, and every pose they can reach is found inside the
// limits; a redundant one keeps clear of them.
#include <gtest/gtest.h>

#include <fstream>

#include "host/urdf_import.hpp"
#include "protocol/config_values.hpp"
#include "shared/inverse_kinematics.hpp"
#include "tests/host/learn_data.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::host {
namespace {

struct UrdfJoint {
  const char *xyz, *axis;
  double limit_rad;
};

/// As on many a factory floor: wrist axes that meet.
const std::vector<UrdfJoint> kSixJoints{{"0 0 0.33", "0 0 1", 2.9},   {"0.08 0 0", "0 1 0", 1.9},
                                        {"0 0 0.33", "0 1 0", 2.2},   {"0.02 0 0.09", "1 0 0", 3.0},
                                        {"0.33 0 0", "0 1 0", 2.0},   {"0.08 0 0", "1 0 0", 3.1}};
/// Shoulder, elbow, wrist like a human arm's.
const std::vector<UrdfJoint> kSevenJoints{{"0 0 0.16", "0 0 1", 2.9}, {"0 0 0.18", "0 1 0", 2.0},
                                          {"0 0 0.21", "0 0 1", 2.9}, {"0 0 0.19", "0 -1 0", 2.0},
                                          {"0 0 0.2", "0 0 1", 2.9},  {"0 0 0.2", "0 1 0", 2.0},
                                          {"0 0 0.08", "0 0 1", 3.0}};

std::string urdf_of(const std::vector<UrdfJoint>& joints) {
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"arm\">\n<link name=\"l0\"/>\n";
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const std::string parent = "l" + std::to_string(i), child = "l" + std::to_string(i + 1);
    const std::string limit = std::to_string(joints[i].limit_rad);
    text += "<link name=\"" + child + "\"/>\n<joint name=\"j" + std::to_string(i + 1) +
            "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" + child + "\"/><origin xyz=\"" +
            joints[i].xyz + "\"/><axis xyz=\"" + joints[i].axis + "\"/><limit lower=\"-" + limit + "\" upper=\"" +
            limit + "\" velocity=\"1\" effort=\"10\"/></joint>\n";
  }
  return text + "</robot>\n";
}

struct Imported {
  SerialChain chain;
  JointVector min_rad, max_rad;
};

Imported import(const std::vector<UrdfJoint>& joints) {
  const test::ScratchFolder folder;
  const auto file = folder.path() / "arm.urdf";
  std::ofstream(file) << urdf_of(joints);
  const StrictYaml yaml =
      StrictYaml::parse(import_urdf(file, "l0", "l" + std::to_string(joints.size())), "imported.yaml");
  Imported arm;
  arm.chain.T_B_0 = read_frame(yaml.root().key("base_to_joint1"));
  arm.min_rad = arm.max_rad = JointVector::Zero(static_cast<Eigen::Index>(joints.size()));
  for (const auto& joint : yaml.root().key("joints").list(1, kMaxJoints)) {
    const int i = arm.chain.joint_count++;
    arm.chain.T_after[static_cast<std::size_t>(i)] = read_frame(joint.key("frame"));
    arm.min_rad[i] = joint.key("min_rad").number(-10, 10);
    arm.max_rad[i] = joint.key("max_rad").number(-10, 10);
  }
  return arm;
}

class UrdfArm : public ::testing::TestWithParam<int> {
 protected:
  const Imported arm = import(GetParam() == 6 ? kSixJoints : kSevenJoints);
};

TEST_P(UrdfArm, FindsEveryReachablePoseInsideItsLimits) {
  ASSERT_EQ(arm.chain.joint_count, GetParam());
  std::mt19937 random(9);
  int solved = 0, near_limit = 0;
  constexpr int kGoals = 300;
  for (int k = 0; k < kGoals; ++k) {
    const Pose goal = forward_kinematics(arm.chain, test::random_between(arm.min_rad, arm.max_rad, random));
    const JointVector seed = test::random_between(arm.min_rad, arm.max_rad, random);
    const auto found = solve_ik(arm.chain, arm.min_rad, arm.max_rad, goal, seed, {.limit_margin_rad = 0.0});
    if (!found || found->orientation_error_rad > 1e-4) continue;
    ++solved;
    EXPECT_LE(found->position_error_m, 1e-5);
    EXPECT_GE((found->q - arm.min_rad).minCoeff(), -1e-12);
    EXPECT_GE((arm.max_rad - found->q).minCoeff(), -1e-12);
    near_limit += (arm.max_rad - found->q.cwiseAbs()).minCoeff() < 0.05 ? 1 : 0;
  }
  EXPECT_GE(solved, kGoals * 99 / 100);
  if (GetParam() == 7) {
    EXPECT_LE(near_limit, kGoals / 20) << "its elbow is free to move";
  }
}

INSTANTIATE_TEST_SUITE_P(Joints, UrdfArm, testing::Values(6, 7));

}  // namespace
}  // namespace armsight::host
