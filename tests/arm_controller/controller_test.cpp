// What the arm does with goals, stops, looks and models, on scripted drives and handed-in time.
#include <gtest/gtest.h>

#include <numbers>

#include "shared/inverse_kinematics.hpp"
#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

JointVector posture(double q1, double q2, double q3, double q4, double q5) {
  JointVector q(5);
  q << q1, q2, q3, q4, q5;
  return q;
}
const JointVector kGoal = posture(0.5, 0.1, -0.4, 1.2, -0.3);

bool reach(ArmRig& rig, const Goal& goal) {
  rig.mailboxes.goal.put(goal);
  if (!rig.bring_to(Mode::kServo, 3)) return false;
  return rig.cycle_until([&] { return rig.state.mode != Mode::kServo; }, 2500) &&
         rig.last<GoalEvent>()->state == GoalState::kArrived;
}

// An elbow at −0.1 rad is beyond its limit (0) and inside what power-on allows (0.35 rad).
TEST(PowerUp, OutsideALimitStandsWhereItIsAndComesBackAtTheJointsPace) {
  ArmRig rig;
  rig.bus.drive(4).position_counts = -0.1 / (2.0 * std::numbers::pi) * 32768.0;
  ASSERT_TRUE(rig.power_up());
  EXPECT_NEAR(rig.state.q_command_rad[3], -0.1, 1e-3);
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  JointVector last = rig.state.q_command_rad;
  for (int i = 0; i < 2500 && (i < 2 || rig.state.mode == Mode::kServo); ++i) {
    rig.cycle();
    const JointVector speed = (rig.state.q_command_rad - last) / rig.robot.controller.period_s;
    ASSERT_LE(speed.cwiseAbs().maxCoeff(), 0.5 + 1e-6) << "cycle " << i;
    last = rig.state.q_command_rad;
  }
  EXPECT_EQ(rig.last<GoalEvent>()->state, GoalState::kArrived);
}

TEST(Goals, AJointGoalIsReachedAndTheDrivesResidualIsTakenAway) {
  ArmRig rig;
  for (int i = 1; i <= 5; ++i) rig.bus.drive(i).residual_counts = i % 2 ? 9.0 : -9.0;  // 0.1°
  ASSERT_TRUE(rig.power_up());
  ASSERT_TRUE(reach(rig, rig.joint_goal(1, kGoal)));
  EXPECT_EQ(rig.state.mode, Mode::kHold);
  EXPECT_LT((rig.last<GoalEvent>()->q_reading_rad - kGoal).cwiseAbs().maxCoeff(), 5e-4);
  EXPECT_LT(rig.last<GoalEvent>()->position_error_m, 3e-4);
}

TEST(Goals, SpeedStaysInsideTheLimits) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  rig.cycle();
  JointVector last = rig.state.q_command_rad;
  while (rig.state.mode == Mode::kServo) {
    rig.cycle();
    const JointVector speed = (rig.state.q_command_rad - last) / rig.robot.controller.period_s;
    ASSERT_LE(speed.cwiseAbs().maxCoeff(), 0.5 + 1e-6);
    last = rig.state.q_command_rad;
  }
}

TEST(Goals, APoseGoalInTheCameraIsReachedOnTheModel) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  Goal goal = rig.joint_goal(2, kGoal);
  goal.kind = GoalKind::kPoseInCamera;
  goal.T_X_G = rig.state.model.T_C_B * forward_kinematics(rig.robot.arm.chain, kGoal);
  goal.position_tolerance_m = 1e-3;
  goal.orientation_tolerance_rad = 0.02;
  ASSERT_TRUE(reach(rig, goal));
  EXPECT_LT(rig.last<GoalEvent>()->position_error_m, 3e-4);
}

TEST(Goals, ANewOneReplacesTheOld) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  rig.cycles(50);
  rig.events.clear();
  rig.mailboxes.goal.put(rig.joint_goal(2, posture(0.1, 0, 0, 0.9, 0)));
  rig.cycles(1);
  EXPECT_EQ(std::get<GoalEvent>(rig.events[1]).state, GoalState::kReplaced);
  EXPECT_EQ(rig.state.goal, 2u);
  EXPECT_TRUE(rig.bring_to(Mode::kHold));
}

TEST(Goals, AreRefusedWithAReasonAndChangeNothing) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.goal.put(rig.joint_goal(2, posture(1.6, 0, 0, 1, 0)));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kOutOfLimits);
  Goal stale = rig.joint_goal(3, kGoal);
  stale.kind = GoalKind::kPoseInBase;
  stale.model_revision = 4;
  rig.mailboxes.goal.put(stale);
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kStaleModel);
  EXPECT_EQ(rig.state.mode, Mode::kHold);
}

TEST(Stop, BrakesHoldsAndStaysPowered) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  rig.cycles(100);
  const JointVector moving = rig.q_reading();
  rig.mailboxes.stop.set();
  rig.cycles(1);
  EXPECT_EQ(rig.state.mode, Mode::kStopping);
  EXPECT_EQ(rig.last<GoalEvent>()->state, GoalState::kStopped);
  ASSERT_TRUE(rig.bring_to(Mode::kHold, 100));
  EXPECT_LT((rig.q_reading() - moving).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_EQ(rig.bus.drive(1).state, DriveState::kOperationEnabled);
}

TEST(Stop, WinsOverAGoalOfTheSameCycle) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  rig.mailboxes.stop.set();
  rig.cycles(2);
  EXPECT_EQ(rig.state.mode, Mode::kHold);
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
}

TEST(Lease, ItsEndStopsTheArmWithin200msPlusBraking) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.goal.put(rig.joint_goal(1, posture(1.4, 0.1, -0.4, 1.2, -0.3)));
  rig.cycles(100);
  ASSERT_EQ(rig.state.mode, Mode::kServo);
  rig.has_commander = false;
  rig.cycles(51);  // 200 ms and a cycle
  EXPECT_NE(rig.state.mode, Mode::kServo);
  EXPECT_TRUE(rig.bring_to(Mode::kHold, 60));
  rig.has_commander = true;
  rig.cycles(100);
  EXPECT_EQ(rig.state.mode, Mode::kHold);  // nothing starts again by itself
}

TEST(Hand, ClosesAtAPaceUnderTheGripLimitAndStopsOnTheObject) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(6).wall_counts = 9000;
  rig.mailboxes.hand.put({{7, 1}, 1.0, 300});
  rig.cycles(50);
  EXPECT_TRUE(rig.state.hand_is_moving);
  EXPECT_EQ(rig.bus.drive(6).object(0x6072, 0), 300u);
  ASSERT_TRUE(rig.cycle_until([&] { return !rig.state.hand_is_moving; }, 500));
  EXPECT_NEAR(rig.state.hand_closure, 9000.0 / 16000.0, 0.01);
}

Look look_at(const ArmRig& rig, const JointVector& beta_true) {
  Look look;
  look.tag = {7, 9};
  look.capture_time = rig.now - std::chrono::milliseconds(20);
  look.time_bound = std::chrono::milliseconds(1);
  look.measurement.T_C_H =
      predict_T_C_H(rig.robot.arm.chain, rig.robot.camera_hint_T_C_B, beta_true, rig.q_reading());
  look.measurement.R_vision = 1e-7 * Matrix6::Identity();
  look.measurement.q = JointVector::Zero(5);
  return look;
}

TEST(Looks, CorrectTheModelAndRaiseItsRevision) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.recalibration.put({{7, 1}, false});
  rig.cycles(60);
  rig.mailboxes.looks.push(look_at(rig, posture(0, 0.02, -0.01, 0.02, 0.01)));
  rig.cycles(1);
  ASSERT_TRUE(rig.last<FilterEvent>());
  EXPECT_EQ(rig.last<FilterEvent>()->report.outcome, FusionOutcome::kFused);
  EXPECT_EQ(rig.state.model.revision, 1u);
  EXPECT_EQ(rig.last<ModelEvent>()->source, ModelSource::kFilter);
  const Vector6 left = pose_error(
      predict_T_C_H(rig.robot.arm.chain, rig.state.model.T_C_B, rig.state.model.beta, rig.q_reading()),
      look_at(rig, posture(0, 0.02, -0.01, 0.02, 0.01)).measurement.T_C_H);
  EXPECT_LT(left.head<3>().norm(), 2e-3);
}

// What is in force is saved and must be loadable (offsets within 20°, camera within 5 m): a look may not leave that.
TEST(Looks, AModelBeyondReasonIsRolledBackAndReported) {
  RobotConfig robot = nominal_robot();
  robot.filter.prior_position_sigma_m = 10.0;
  ArmRig rig(robot);
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.recalibration.put({{7, 1}, false});
  rig.cycles(60);
  Look far = look_at(rig, JointVector::Zero(5));
  far.measurement.T_C_H.p.z() += 7.0;
  rig.mailboxes.looks.push(far);
  rig.cycle();
  EXPECT_EQ(rig.last_answer(), Answer::kImplausible);
  EXPECT_EQ(rig.last<FilterEvent>()->look, LookOutcome::kImplausible);
  EXPECT_EQ(rig.state.model.revision, 0u);
  rig.mailboxes.looks.push(look_at(rig, posture(0, 0.02, 0, 0, 0)));  // the filter stands where it stood
  rig.cycle();
  EXPECT_EQ(rig.state.model.revision, 1u);
  EXPECT_LT((rig.state.model.T_C_B.p - robot.camera_hint_T_C_B.p).norm(), 0.1);
}

TEST(Looks, AreRefusedOutOfTimeMovingOrWithoutRecalibration) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.cycles(60);
  rig.mailboxes.looks.push(look_at(rig, JointVector::Zero(5)));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
  rig.mailboxes.recalibration.put({{7, 1}, false});
  rig.cycles(1);
  Look late = look_at(rig, JointVector::Zero(5));
  late.capture_time = rig.now + std::chrono::seconds(1);
  rig.mailboxes.looks.push(late);
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kTime);
  EXPECT_EQ(rig.last<FilterEvent>()->look, LookOutcome::kNoJoints);
  Look vague = look_at(rig, JointVector::Zero(5));
  vague.time_bound = std::chrono::milliseconds(50);
  rig.mailboxes.looks.push(vague);
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kTime);
  rig.mailboxes.goal.put(rig.joint_goal(1, kGoal));
  rig.cycles(100);
  rig.mailboxes.looks.push(look_at(rig, JointVector::Zero(5)));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kMoving);
  EXPECT_EQ(rig.state.model.revision, 0u);
}

Proposal proposal(const ArmRig& rig, std::uint64_t parent, double beta2) {
  Proposal p;
  p.tag = {7, 5};
  p.parent_revision = parent;
  p.model = {0, rig.robot.camera_hint_T_C_B, posture(0, beta2, 0, 0, 0)};
  return p;
}

TEST(Proposals, AreTakenInHoldOnTheRevisionInForceAndWithinReason) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  rig.mailboxes.proposal.put(proposal(rig, 0, 0.1));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kWrongState);
  ASSERT_TRUE(rig.power_up());
  rig.mailboxes.proposal.put(proposal(rig, 3, 0.1));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kStaleModel);
  rig.mailboxes.proposal.put(proposal(rig, 0, 0.4));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kImplausible);
  rig.mailboxes.proposal.put(proposal(rig, 0, 0.1));
  rig.cycles(1);
  EXPECT_EQ(rig.last_answer(), Answer::kAccepted);
  EXPECT_EQ(rig.state.model.revision, 1u);
  EXPECT_EQ(rig.state.model.beta[1], 0.1);
}

TEST(Cycle, TenLateInARowAreAFault) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  for (int i = 0; i < 9; ++i) {
    ++rig.missed;
    rig.cycle();
  }
  EXPECT_EQ(rig.state.mode, Mode::kHold);
  ++rig.missed;
  rig.cycle();
  EXPECT_EQ(rig.state.fault.code, FaultCode::kCycleOverrun);
}

}  // namespace
}  // namespace armsight::arm::test
