// `host robot import`: a URDF with odd axes and fixed joints between becomes the same arm.
#include <gtest/gtest.h>

#include <fstream>

#include "host/robot_description.hpp"
#include "host/urdf_import.hpp"
#include "protocol/config_values.hpp"
#include "tests/host/learn_data.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::host {
namespace {

constexpr const char* kUrdf = R"(<?xml version="1.0"?>
<robot name="odd">
  <link name="base"/><link name="plate"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="flange"/><link name="side"/>
  <joint name="bolted" type="fixed"><parent link="base"/><child link="plate"/><origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/></joint>
  <joint name="one" type="revolute"><parent link="plate"/><child link="l1"/><origin xyz="0 0.1 0" rpy="1.5707963267948966 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="2" velocity="0.4" effort="1"/></joint>
  <joint name="two" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="0.2 0 0.05" rpy="0.1 1.5707963267948966 -0.7"/><axis xyz="0 0 -1"/></joint>
  <joint name="three" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0 0 0.3"/><axis xyz="0.6 0 0.8"/>
    <limit lower="-3" upper="3" velocity="9" effort="1"/></joint>
  <joint name="glued" type="fixed"><parent link="l3"/><child link="flange"/><origin xyz="0 0.02 0.1" rpy="-1 0.2 3"/></joint>
  <joint name="slides" type="prismatic"><parent link="l1"/><child link="side"/><axis xyz="1 0 0"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint>
</robot>)";

/// The same arm by hand, product of joint frames and axis turns.
Pose by_hand(double q1, double q2, double q3) {
  const auto frame = [](Vector3 xyz, Vector3 rpy) { return Pose{from_rpy(rpy), xyz}; };
  const auto turn = [](const Vector3& axis, double angle) { return Pose{so3_exp(angle * axis), Vector3::Zero()}; };
  constexpr double kQuarter = 1.5707963267948966;
  return frame({0.1, -0.2, 0.3}, {0.4, -0.5, 0.6}) * frame({0, 0.1, 0}, {kQuarter, 0, 0}) * turn({1, 0, 0}, q1) *
         frame({0.2, 0, 0.05}, {0.1, kQuarter, -0.7}) * turn({0, 0, -1}, q2) * frame({0, 0, 0.3}, {0, 0, 0}) *
         turn({0.6, 0, 0.8}, q3) * frame({0, 0.02, 0.1}, {-1, 0.2, 3});
}

class UrdfImport : public ::testing::Test {
 protected:
  void SetUp() override { std::ofstream(file()) << kUrdf; }
  std::filesystem::path file() const { return folder_.path() / "odd.urdf"; }
  std::string refusal(const std::string& base, const std::string& tip) {
    try {
      import_urdf(file(), base, tip);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  test::ScratchFolder folder_;
};

/// Reads the imported text back as the robot file's reader does.
SerialChain read_back(const std::string& text) {
  const StrictYaml yaml = StrictYaml::parse(text, "imported.yaml");
  SerialChain chain;
  chain.T_B_0 = read_frame(yaml.root().key("base_to_joint1"));
  for (const auto& joint : yaml.root().key("joints").list(1, kMaxJoints)) {
    chain.T_after[static_cast<std::size_t>(chain.joint_count++)] = read_frame(joint.key("frame"));
  }
  return chain;
}

TEST_F(UrdfImport, GivesTheSameForwardKinematicsTo1e12) {
  const SerialChain chain = read_back(import_urdf(file(), "base", "flange"));
  ASSERT_EQ(chain.joint_count, 3);
  std::mt19937 random(1);
  for (int k = 0; k < 100; ++k) {
    const Vector3 q = test::random_vector(1.5, random);
    const Pose wanted = by_hand(q[0], q[1], q[2]), got = forward_kinematics(chain, test::joints({q[0], q[1], q[2]}));
    EXPECT_LT((wanted.R - got.R).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((wanted.p - got.p).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST_F(UrdfImport, SaysWhatItCannotTake) {
  EXPECT_NE(refusal("base", "hand").find("link hand: is not in this robot"), std::string::npos);
  EXPECT_NE(refusal("l2", "l1").find("link l1: does not hang from link l2"), std::string::npos);
  EXPECT_NE(refusal("base", "side").find("joint slides: must be revolute, continuous or fixed"), std::string::npos);
  EXPECT_NE(refusal("base", "plate").find("0 joints: must be 1 to 8"), std::string::npos);
}

TEST(RollPitchYaw, ComesBackExactlyAlsoAtTheGimbal) {
  std::mt19937 random(2);
  for (int k = 0; k < 200; ++k) {
    Vector3 rpy = test::random_vector(1.5, random);
    if (k % 4 == 0) rpy.y() = k % 8 == 0 ? M_PI / 2 : -M_PI / 2;
    if (k % 5 == 0) rpy.y() = M_PI / 2 - 1e-9;
    EXPECT_LT((from_rpy(to_rpy(from_rpy(rpy))) - from_rpy(rpy)).cwiseAbs().maxCoeff(), 2e-15) << rpy.transpose();
  }
}

}  // namespace
}  // namespace armsight::host
