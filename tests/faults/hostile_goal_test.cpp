// Row 10: goals that are no numbers, out of reach, beyond limits, or somewhere else every cycle. Refused with a reason,
// or followed inside every limit of position, speed, acceleration and jerk: the rig judges each set-point.
#include <cmath>
#include <limits>

#include "tests/faults/linked_rig.hpp"
#include "tools/sim/random.hpp"

namespace armsight::faults {
namespace {

class HostileGoal : public ::testing::Test {
 protected:
  LinkedRig rig;
  std::unique_ptr<Peer> host = rig.powered_commander();

  void expect_refused(const wire::Envelope& goal, const std::string& what) {
    EXPECT_NE(rig.refusal_of(*host, host->send(goal)), wire::REFUSAL_REASON_UNSPECIFIED) << what;
  }
};

TEST_F(HostileGoal, ThatIsNoGoalIsRefusedAndMovesNothing) {
  const Time began = rig.now;
  const JointVector good = FaultRig::posture(0.3, 0.1, -0.3, 1.0, 0.2);
  const double bad[] = {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                        1e300, -1e300, 7.0};
  for (const double value : bad) {
    for (int i = 0; i < kJoints; ++i) {
      JointVector q = good;
      q[i] = value;
      expect_refused(LinkedRig::joint_goal(q), "joint " + std::to_string(i) + " at " + std::to_string(value));
    }
    expect_refused(LinkedRig::joint_goal(good, value), "speed scale " + std::to_string(value));
    wire::Envelope far = rig.pose_goal(good);
    far.mutable_pose_goal()->mutable_hand_goal()->set_x_m(value);
    expect_refused(far, "x " + std::to_string(value));
  }
  for (const double scale : {0.0, -1.0}) expect_refused(LinkedRig::joint_goal(good, scale), "speed scale");
  wire::Envelope flat = rig.pose_goal(good);
  for (auto* pose : {flat.mutable_pose_goal()->mutable_hand_goal()}) {
    pose->set_qw(0);
    pose->set_qx(0);
    pose->set_qy(0);
    pose->set_qz(0);
  }
  expect_refused(flat, "quaternion of length zero");
  wire::Envelope loose = rig.pose_goal(good);
  loose.mutable_pose_goal()->set_position_tolerance_m(std::nan(""));
  expect_refused(loose, "tolerance that is no number");
  EXPECT_LT(rig.travelled_rad(began), kCount_rad);
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

TEST_F(HostileGoal, SomewhereElseAllTheTimeIsFollowedInsideTheLimits) {
  sim::Random random(1, 920);
  const JointLimits& limits = rig.robot.arm.limits;
  for (int i = 0; i < 1500; ++i) {
    JointVector q(kJoints);
    for (int k = 0; k < kJoints; ++k) q[k] = random.uniform(limits.min_rad[k], limits.max_rad[k]);
    host->send(LinkedRig::joint_goal(q, random.uniform(0.01, 1.0)));
    rig.cycle();
    host->take();
    ASSERT_LT(rig.fastest_rad_s(), 0.55) << "cycle " << i;
  }
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

/// Whatever the link let through: the generator of set-points has limits of its own.
TEST(HostileOrder, FasterThanTheArmKeepsTheArmsLimits) {
  FaultRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.send_goal(FaultRig::far_goal(), 50.0);
  for (int i = 0; i < 700; ++i) {
    rig.cycle();
    ASSERT_LT(rig.fastest_rad_s(), 0.55) << "cycle " << i;
  }
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

}  // namespace
}  // namespace armsight::faults
