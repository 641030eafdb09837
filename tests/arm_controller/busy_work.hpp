// Six seconds of work for the tick: every kind of order once, each at its cycle, and what must come of them.
#pragma once

#include "arm_controller/messages.hpp"
#include "protocol/config.hpp"
#include "shared/hand_eye.hpp"

namespace armsight::arm::test {

inline constexpr int kBusyCycles = 1500;

inline Goal goal_of_session_7(std::uint64_t id, const JointVector& q_real) {
  Goal goal;
  goal.tag = {7, id};
  goal.id = id;
  goal.q_real_rad = q_real;
  return goal;
}

/// Session 7 gives them; a cycle is 4 ms.
inline void fill(TickInbox& inbox, int cycle, Time now, const RobotConfig& robot, const JointVector& q) {
  inbox.lease = Lease{7, now + std::chrono::seconds(1)};
  inbox.mode.reset();
  inbox.proposal.reset();
  inbox.recalibration.reset();
  inbox.goal.reset();
  inbox.hand.reset();
  inbox.look_count = 0;
  const Pose& T_C_B = robot.camera_hint_T_C_B;
  if (cycle == 10) inbox.mode = ModeOrder{{7, 1}, PowerWish::kHold, false};
  if (cycle == 40) inbox.proposal = Proposal{{7, 2}, 0, {0, T_C_B, JointVector::Zero(5)}, false, {}};
  if (cycle == 60) inbox.recalibration = RecalibrationOrder{{7, 3}, false};
  if (cycle == 100) {
    Look& look = inbox.looks[inbox.look_count++];
    look.tag = {7, 4};
    look.capture_time = now - std::chrono::milliseconds(10);
    look.measurement.T_C_H = predict_T_C_H(robot.arm.chain, T_C_B, JointVector::Constant(5, 0.005), q);
    look.measurement.R_vision = 1e-6 * Matrix6::Identity();
    look.measurement.q = q;
  }
  if (cycle == 150) inbox.hand = HandOrder{{7, 5}, 0.5, 300};
  if (cycle == 200) inbox.goal = goal_of_session_7(6, q + JointVector::Constant(5, 0.1));
  if (cycle == 700) {
    inbox.goal = goal_of_session_7(7, q + JointVector::Constant(5, 0.1));
    inbox.goal->kind = GoalKind::kPoseInBase;
    inbox.goal->T_X_G = forward_kinematics(robot.arm.chain, inbox.goal->q_real_rad);
    inbox.goal->model_revision = 2;
    inbox.goal->position_tolerance_m = 1e-3;
    inbox.goal->orientation_tolerance_rad = 0.02;
  }
  if (cycle == 1400) inbox.stop = true;
}

/// What came out, so that no order was refused unseen.
struct BusyOutcome {
  int accepted = 0, refused = 0, arrived = 0, fused = 0;
  void count(const Event& event) {
    if (const auto* answer = std::get_if<AnswerEvent>(&event))
      ++(answer->answer == Answer::kAccepted ? accepted : refused);
    if (const auto* goal = std::get_if<GoalEvent>(&event)) arrived += goal->state == GoalState::kArrived;
    if (const auto* look = std::get_if<FilterEvent>(&event)) fused += look->report.outcome == FusionOutcome::kFused;
  }
  bool is_complete() const { return refused == 0 && accepted == 7 && fused == 1 && arrived == 2; }
};

}  // namespace armsight::arm::test
