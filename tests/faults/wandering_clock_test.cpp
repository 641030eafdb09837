// Row 9: the host's clock steps, drifts, runs ahead. The cycle does not notice; looks whose time is not known are not
// fused. The host's half (alignment, step detection, bounds at 100 ppm): app_clock_alignment_test, moving_arm_test.
#include "shared/hand_eye.hpp"
#include "tests/faults/linked_rig.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;

class WanderingClock : public ::testing::Test {
 protected:
  LinkedRig rig;
  std::unique_ptr<Peer> host = rig.powered_commander();

  /// A look at a hand that is 5 mm beside where the model has it: one that is fused changes the model.
  arm::Look look(Time capture, Duration bound) const {
    arm::Look look;
    look.tag = {host->session, 1'000'000};
    look.capture_time = capture;
    look.time_bound = bound;
    look.measurement.T_C_H =
        predict_T_C_H(rig.robot.arm.chain, rig.robot.camera_hint_T_C_B, JointVector::Zero(kJoints), rig.q_rad());
    look.measurement.T_C_H.p.x() += 0.005;
    look.measurement.R_vision = 1e-7 * Matrix6::Identity();
    look.measurement.q = JointVector::Zero(kJoints);
    return look;
  }
  std::uint64_t revision_after(const arm::Look& look) {
    rig.mailboxes.looks.push(look);
    rig.cycles(3);
    return rig.state.model.revision;
  }
  void open_the_filter() {
    wire::Envelope start;
    start.mutable_recalibration_start();
    ASSERT_EQ(rig.refusal_of(*host, host->send(start)), wire::REFUSAL_REASON_UNSPECIFIED);
    rig.cycles(60);
  }
};

TEST_F(WanderingClock, SteppingUnderWayChangesNothingOfTheMotion) {
  LinkedRig steady;
  const auto calm = steady.powered_commander();
  for (auto* peer : {host.get(), calm.get()}) peer->send(LinkedRig::joint_goal(FaultRig::far_goal()));
  for (int i = 0; i < 400; ++i) {
    if (i == 100) host->clock_offset_ns += 3'600'000'000'000;
    if (i == 200) host->clock_offset_ns -= 7'200'000'000'000;
    host->clock_offset_ns += 400;  // 100 ppm
    rig.cycle();
    steady.cycle();
    host->take();
    calm->take();
  }
  EXPECT_LT((rig.q_rad() - steady.q_rad()).cwiseAbs().maxCoeff(), kCount_rad);
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

TEST_F(WanderingClock, LooksFromTheFutureOrOfUnknownTimeAreNotFused) {
  open_the_filter();
  EXPECT_EQ(revision_after(look(rig.now + 1s, 1ms)), 0U) << "from the future";
  EXPECT_EQ(revision_after(look(rig.now - 1h, 1ms)), 0U) << "from before the last step";
  EXPECT_EQ(revision_after(look(rig.now - 20ms, 50ms)), 0U) << "bound too wide";
  EXPECT_EQ(revision_after(look(rig.now - 20ms, -1ms)), 0U) << "no bound at all";
  EXPECT_EQ(revision_after(look(rig.now - 20ms, 1ms)), 1U) << "aligned again";
}

}  // namespace
}  // namespace armsight::faults
