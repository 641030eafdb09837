// What --dry-run tells: the time a trip takes, its posture, and why it would be refused.
#include "host/planned_motion.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace armsight::host {
namespace {

const RobotConfig& planned_robot() {
  static const RobotConfig robot = load_robot(ARMSIGHT_ROBOT_YAML);
  return robot;
}

LearnedModel planned_model(double beta_rad = 0.0) {
  return {1, planned_robot().camera_hint_T_C_B, JointVector::Constant(5, beta_rad)};
}

const JointVector& ready() { return planned_robot().postures.at("ready"); }

JointVector ready_but(Eigen::Index joint, double by_rad) {
  JointVector q = ready();
  q[joint] += by_rad;
  return q;
}

// v/A + A/J to reach 0.5 rad/s at 4 rad/s², 80 rad/s³, the same to stop, the rest at full speed.
TEST(PlannedMotion, TakesTheTimeOfTheJerkLimitedTrip) {
  const PlannedMotion motion = plan_motion(planned_robot(), planned_model(), ready(), ready_but(0, 1.0), 1.0);
  EXPECT_TRUE(motion.refusal.empty()) << motion.refusal;
  EXPECT_NEAR(motion.duration_s, 1.0 / 0.5 + 0.5 / 4 + 4.0 / 80, 0.01);
  const PlannedMotion slow = plan_motion(planned_robot(), planned_model(), ready(), ready_but(0, 1.0), 0.1);
  EXPECT_NEAR(slow.duration_s, 1.0 / 0.05 + std::sqrt(4 * 0.05 / 80), 0.05);
}

TEST(PlannedMotion, NamesTheJointThatReadingOrRealAngleWouldTakeBeyondItsLimit) {
  const JointVector edge = ready_but(1, 0.80 - ready()[1]);
  EXPECT_TRUE(plan_motion(planned_robot(), planned_model(0.05), ready(), edge, 1.0).refusal.empty());
  const PlannedMotion motion = plan_motion(planned_robot(), planned_model(-0.05), ready(), edge, 1.0);
  EXPECT_NE(motion.refusal.find("shoulder_abduction"), std::string::npos) << motion.refusal;
  EXPECT_EQ(motion.duration_s, 0.0);
}

TEST(PlannedMotion, ToAPoseEndsInThePostureThatReachesIt) {
  const Pose T_B_G = forward_kinematics(planned_robot().arm.chain, ready_but(3, -0.4));
  const PlannedMotion motion = plan_motion(planned_robot(), planned_model(), ready(), T_B_G, 0.02, 1.0);
  ASSERT_TRUE(motion.refusal.empty()) << motion.refusal;
  EXPECT_LT(pose_error(forward_kinematics(planned_robot().arm.chain, motion.q_to), T_B_G).norm(), 1e-3);
  const Pose far{T_B_G.R, 3.0 * T_B_G.p};
  EXPECT_FALSE(plan_motion(planned_robot(), planned_model(), ready(), far, 0.02, 1.0).refusal.empty());
}

TEST(PlannedMotion, TellsStartGoalAndWayOfEachJoint) {
  std::ostringstream out;
  tell("move", plan_motion(planned_robot(), planned_model(), ready(), ready_but(3, -0.5), 1.0), planned_robot(), out);
  for (const std::string& name : planned_robot().joint_names) EXPECT_NE(out.str().find(name), std::string::npos);
  EXPECT_NE(out.str().find("108.86 ->    80.21 deg  (-28.65)"), std::string::npos) << out.str();
  EXPECT_NE(out.str().find("takes"), std::string::npos);
}

}  // namespace
}  // namespace armsight::host
