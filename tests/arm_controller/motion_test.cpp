// Every set-point that a goal, a stop, a trim or a new model makes obeys the joints' limits, jerk among them. Drives
// are played by a lag and an offset; time is handed in.
#include "arm_controller/motion.hpp"

#include <gtest/gtest.h>

#include "tests/arm_controller/arm_rig.hpp"
#include "tests/shared/default_arm.hpp"
#include "tests/shared/setpoint_judge.hpp"

namespace armsight::arm::test {
namespace {

using armsight::test::joints;
using armsight::test::random_between;
using armsight::test::SetpointJudge;

const JointVector kStart = joints({0.1, 0.1, -0.2, 0.9, 0.1});
const JointVector kMotionGoal = joints({0.5, -0.3, -0.4, 1.2, -0.3});

class MotionTest : public testing::Test {
 protected:
  const RobotConfig robot = nominal_robot();
  Motion motion{robot};
  LearnedModel model{0, robot.camera_hint_T_C_B, JointVector::Zero(5)};
  StillnessWatch watch{5, robot.controller.still_speed_rad_s, robot.controller.still_time_s, robot.controller.period_s};
  SetpointJudge judge{robot.arm.limits, robot.controller.period_s};
  JointVector reading = kStart, drive_offset = joints({0.002, -0.001, 0.003, -0.002, 0.001});
  std::mt19937 random{1};

  void SetUp() override { motion.stand_at(kStart); }

  void play_drives() {
    reading += 0.3 * (motion.command_rad() + drive_offset - reading);
    watch.push(reading);
    judge.take(motion.command_rad());
  }
  Progress cycle() {
    const Progress progress = motion.step_to_goal(model, watch);
    play_drives();
    return progress;
  }
  Progress run(int at_most = 4000) {
    Progress progress = Progress::kMoving;
    for (int k = 0; k < at_most && progress == Progress::kMoving && !HasFatalFailure(); ++k) progress = cycle();
    return progress;
  }
  void revise(double beta_rad) {
    ++model.revision;
    model.beta = random_between(JointVector::Constant(5, -beta_rad), JointVector::Constant(5, beta_rad), random);
    model.T_C_B = robot.camera_hint_T_C_B * Pose{so3_exp(0.02 * Vector3::Random()), 0.01 * Vector3::Random()};
    motion.model_changed(model);
  }
  Goal goal_at(const JointVector& q_real, GoalKind kind) const {
    Goal goal;
    goal.kind = kind;
    goal.q_real_rad = q_real;
    const Pose T_B_G = forward_kinematics(robot.arm.chain, q_real);
    goal.T_X_G = kind == GoalKind::kPoseInCamera ? model.T_C_B * T_B_G : T_B_G;
    goal.position_tolerance_m = 1e-3;
    goal.orientation_tolerance_rad = 0.1;  // five joints: a goal moved with the camera is met in place only
    return goal;
  }
};

TEST_F(MotionTest, AJointGoalIsMetByTheEncodersThoughTheDrivesAreOff) {
  motion.start(goal_at(kMotionGoal, GoalKind::kJoints), model);
  ASSERT_EQ(run(), Progress::kArrived);
  EXPECT_LT((reading - kMotionGoal).cwiseAbs().maxCoeff(), 5e-4);
  motion.start(goal_at(kStart, GoalKind::kJoints), model);
  ASSERT_EQ(run(), Progress::kArrived);
  EXPECT_LT((reading - kStart).cwiseAbs().maxCoeff(), 5e-4);
}

TEST_F(MotionTest, TheTrimGoesNoFartherThanItsLimit) {
  drive_offset[1] = -0.1;
  motion.start(goal_at(kMotionGoal, GoalKind::kJoints), model);
  EXPECT_EQ(run(), Progress::kGivenUp);
  EXPECT_NEAR(motion.command_rad()[1] - kMotionGoal[1], 0.02, 1e-3);
}

TEST_F(MotionTest, AStopAtAnyMomentBrakesInsideTheLimits) {
  for (int k = 0; k < 400; k += 7) {
    motion.start(goal_at(k % 2 ? kMotionGoal : kStart, k % 3 ? GoalKind::kJoints : GoalKind::kPoseInCamera), model);
    for (int i = 0; i < k; ++i) cycle();
    int braking = 0;
    while (!motion.is_at_rest() && ++braking < 1000) {
      motion.step_to_rest();
      play_drives();
      ASSERT_FALSE(HasFatalFailure());
    }
    EXPECT_LE(braking, (0.5 / 4.0 + 2 * 4.0 / 80.0) / 0.004 + 1);  // ramp to nothing, and brake
  }
}

TEST_F(MotionTest, ARevisedModelOnTheWayMakesNoJumpAndIsWhatTheGoalIsMetOn) {
  for (const GoalKind kind : {GoalKind::kJoints, GoalKind::kPoseInBase, GoalKind::kPoseInCamera}) {
    motion.start(goal_at(kMotionGoal, kind), model);
    for (int k = 0; k < 600; ++k) {
      if (k % 40 == 17) revise(0.05);
      cycle();
      ASSERT_FALSE(HasFatalFailure()) << "cycle " << k;
    }
    ASSERT_EQ(run(), Progress::kArrived);
    double position_m, orientation_rad;
    motion.errors_at(reading, model, position_m, orientation_rad);
    if (kind != GoalKind::kJoints) EXPECT_LT(position_m, 1e-3);
    else EXPECT_LT((reading + model.beta - kMotionGoal).cwiseAbs().maxCoeff(), 5e-4);
    motion.start(goal_at(kStart, GoalKind::kJoints), model);
    ASSERT_EQ(run(), Progress::kArrived);
  }
}

TEST_F(MotionTest, NeitherReadingNorRealAnglePassesALimit) {
  revise(0.05);
  const JointVector edge = joints({1.56, 0.80, -1.56, 2.34, 1.56});  // real; beta moves the reading beyond or before it
  motion.start(goal_at(edge, GoalKind::kJoints), model);
  const auto& limits = robot.arm.limits;
  for (int k = 0; k < 2500; ++k) {
    cycle();
    const JointVector q = motion.command_rad();
    ASSERT_LE((q + model.beta - limits.max_rad).maxCoeff(), 1e-12);
    ASSERT_LE((limits.min_rad - q - model.beta).maxCoeff(), 1e-12);
  }
}

// Whatever comes in whatever order.
TEST_F(MotionTest, SevenMinutesOfGoalsStopsAndModelsKeepsEveryLimit) {
  std::uniform_real_distribution<double> u(0.0, 1.0);
  bool is_stopping = false;
  for (int k = 0; k < 100000; ++k) {
    if (u(random) < 0.01) {
      const auto kind = static_cast<GoalKind>(static_cast<int>(3 * u(random)));
      Goal goal = goal_at(random_between(robot.arm.limits.min_rad, robot.arm.limits.max_rad, random), kind);
      goal.speed_scale = 0.1 + 0.9 * u(random);
      motion.start(goal, model);
      is_stopping = false;
    }
    if (u(random) < 0.005) is_stopping = true;
    if (u(random) < 0.01) revise(0.03);
    if (is_stopping) motion.step_to_rest();
    else motion.step_to_goal(model, watch);
    play_drives();
    ASSERT_FALSE(HasFatalFailure()) << "cycle " << k;
  }
}

}  // namespace
}  // namespace armsight::arm::test
