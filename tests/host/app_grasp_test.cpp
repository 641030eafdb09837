// The grasp table and what is made of it: strict reading, choice on the reachable set, the verdict of the hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "host/grasp_plan.hpp"
#include "tests/host/app_robot.hpp"

namespace armsight::host {
namespace {

const char* const kTable = R"(objects:
  can:
    marker: {dictionary: DICT_4X4_50, id: 12, side_m: 0.040, position_m: [0, 0, 0.0585], rotation_rows: [[1,0,0],[0,1,0],[0,0,1]]}
    hand: {force_limit_permille: 500, grasped_below_closure: 0.97}
    tolerance: {position_m: 0.002, orientation_rad: 0.035}
    grasps:
      - {name: up, position_m: [0.035, -0.060, 0], rotation_rows: [[1,0,0],[0,1,0],[0,0,1]], free_yaw: true, retreat_m: [0, 0.06, 0]}
      - {name: down, position_m: [0.035, -0.060, 0], rotation_rows: [[1,0,0],[0,-1,0],[0,0,-1]], free_yaw: true, retreat_m: [0, 0.06, 0]}
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kTable;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string refusal_of(const std::string& text) {
  try {
    GraspTable::parse(text, "grasps.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

TEST(GraspTable, ReadsTheShippedFile) {
  const GraspTable table = GraspTable::load(ARMSIGHT_GRASPS_YAML);
  const GraspObject& can = table.find("can");
  EXPECT_EQ(can.marker.id, 12);
  EXPECT_EQ(can.grasps.size(), 2u);
  EXPECT_NEAR(can.T_O_M.p.z(), 0.0585, 1e-12);
}

TEST(GraspTable, NamesPlaceAndRuleOfEveryViolation) {
  EXPECT_NE(refusal_of(changed("side_m: 0.040", "side_m: -1")).find("grasps.yaml:3:"), std::string::npos);
  EXPECT_NE(refusal_of(changed("[[1,0,0],[0,1,0],[0,0,1]]}", "[[1,0,0],[0,1,0],[0,0,-1]]}")).find("rotation"),
            std::string::npos);
  EXPECT_NE(refusal_of(changed("free_yaw: true", "free_yaw: maybe")).find("free_yaw"), std::string::npos);
  EXPECT_NE(refusal_of(changed("force_limit_permille", "force")).find("force_limit_permille"), std::string::npos);
  EXPECT_NE(refusal_of(changed("hand: {", "hand: {extra: 1, ")).find("extra"), std::string::npos);
  EXPECT_FALSE(refusal_of("objects: {}").empty());
  const std::string both = refusal_of(changed("side_m: 0.040", "side_m: -1").replace(0, 0, "wrong: 1\n"));
  EXPECT_NE(both.find("wrong"), std::string::npos);
  EXPECT_NE(both.find("side_m"), std::string::npos);
}

TEST(GraspTable, UnknownObjectListsTheKnownOnes) {
  const GraspTable table = GraspTable::parse(kTable, "grasps.yaml");
  try {
    (void)table.find("cup");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("can"), std::string::npos);
  }
}

TEST(GraspEntry, FreeYawTurnsTheHandAboutTheObject) {
  const GraspTable table = GraspTable::parse(kTable, "grasps.yaml");
  for (const GraspEntry& grasp : table.find("can").grasps) {
    for (const double yaw : {0.0, 0.7, -2.0}) {
      const Pose T_O_G = grasp.T_O_G(yaw);
      EXPECT_NEAR((T_O_G.inverse().p - Vector3(0.035, -0.060, 0)).norm(), 0.0, 1e-12);
      EXPECT_NEAR(std::abs(T_O_G.R(2, 2)), 1.0, 1e-12);
      const Pose before = grasp.pregrasp(T_O_G);
      EXPECT_NEAR((before.p - T_O_G.p).dot(T_O_G.R.col(1)), 0.06, 1e-12);
    }
  }
}

ReachProblem reach() {
  const ArmModel arm = test_arm();
  ReachProblem r{arm.chain, arm.limits.min_rad.array() + 0.05, arm.limits.max_rad.array() - 0.05, JointVector(5)};
  r.q_seed << 0.3, -0.3, -0.3, 1.2, -0.3;
  return r;
}

// z_O up against gravity, at the place where the demo's can stands.
Pose can_pose(const Vector3& offset) {
  const Vector3 up = Vector3(9.66095, 0.29581, 1.67761).normalized();
  Pose T;
  T.R.col(2) = up;
  T.R.col(0) = up.cross(Vector3::UnitY()).normalized();
  T.R.col(1) = T.R.col(2).cross(T.R.col(0));
  T.p = Vector3(-0.12, -0.28, -0.10) + offset;
  return T;
}

TEST(GraspPlan, FindsACertifiedPostureAroundTheDemoPlace) {
  const GraspTable table = GraspTable::parse(kTable, "grasps.yaml");
  const GraspObject& can = table.find("can");
  for (const Vector3& offset :
       {Vector3(0, 0, 0), Vector3(0.01, 0.01, 0.01), Vector3(-0.01, 0.01, -0.01), Vector3(0, -0.01, 0.01)}) {
    const GraspPlan plan = plan_grasp(reach(), can, can_pose(offset));
    ASSERT_TRUE(plan.best) << (plan.refusals.empty() ? "" : plan.refusals.front());
    const Vector6 e = pose_error(forward_kinematics(reach().chain, plan.best->at_grasp.q), plan.best->T_B_G);
    EXPECT_LT(e.head<3>().norm(), 1e-4);
    EXPECT_LT(e.tail<3>().norm(), can.orientation_tolerance_rad);
    EXPECT_LT((plan.best->at_grasp.q - plan.best->at_pregrasp.q).lpNorm<Eigen::Infinity>(), 0.9);
  }
}

TEST(GraspPlan, ExplainsWhyNothingIsReachable) {
  const GraspTable table = GraspTable::parse(kTable, "grasps.yaml");
  const GraspPlan plan = plan_grasp(reach(), table.find("can"), can_pose(Vector3(0, -0.5, 0)));
  EXPECT_FALSE(plan.best);
  ASSERT_EQ(plan.refusals.size(), 2u);
  EXPECT_NE(plan.refusals[0].find("up: "), std::string::npos);
  EXPECT_NE(plan.refusals[0].find("reach"), std::string::npos);
}

TEST(GraspPlan, LiftsTheHandFromTheCanAgainstGravityAndNeverLower) {
  const GraspTable table = GraspTable::parse(kTable, "grasps.yaml");
  const GraspPlan plan = plan_grasp(reach(), table.find("can"), can_pose(Vector3::Zero()));
  ASSERT_TRUE(plan.best);
  ReachProblem at_grasp = reach();
  at_grasp.q_seed = plan.best->at_grasp.q;
  const Vector3 up = can_pose(Vector3::Zero()).R.col(2);
  const auto lifted = plan_lift(at_grasp, up);
  ASSERT_TRUE(lifted);
  const Vector3 start = forward_kinematics(at_grasp.chain, at_grasp.q_seed).p;
  const Vector3 way = forward_kinematics(at_grasp.chain, *lifted).p - start;
  EXPECT_GT(up.dot(way), kLift_m / 3 - 1e-4);
  EXPECT_LT((way - up.dot(way) * up).norm(), 1e-4) << "straight up";
  for (int k = 1; k <= 50; ++k) {
    const JointVector q = at_grasp.q_seed + (*lifted - at_grasp.q_seed) * k / 50;
    EXPECT_GT(up.dot(forward_kinematics(at_grasp.chain, q).p - start), -0.003);
  }
  const Vector3 outward = start.normalized();
  at_grasp.q_seed[3] = at_grasp.min_rad[3];
  EXPECT_FALSE(plan_lift(at_grasp, outward)) << "a stretched arm reaches no farther";
}

TEST(GraspVerdict, AsksForBothOpeningAndForce) {
  const GraspTable table = GraspTable::parse(kTable, "grasps.yaml");
  const GraspObject& can = table.find("can");
  EXPECT_EQ(judge_grasp(can, 0.6, 480), GraspVerdict::kGrasped);
  EXPECT_EQ(judge_grasp(can, 1.0, 480), GraspVerdict::kEmpty);
  EXPECT_EQ(judge_grasp(can, 0.6, 20), GraspVerdict::kEmpty);
}

}  // namespace
}  // namespace armsight::host
