// Drive somewhere and be still; open and close the hand. Each call waits for the end and says how it ended.
// Angles real (reading + beta), rad; the controller subtracts the beta in force.
#pragma once

#include <string>

#include "host/host_io.hpp"

namespace armsight::host {

struct MotionResult {
  bool has_arrived = false;
  std::string why;           ///< not arrived: refused or stopped, and why
  wire::GoalStatus status;   ///< the last one of this goal; empty when refused
};

/// Joint angles now: reading, and real with the beta in force.
JointVector reading_now(HostIo& io);
JointVector real_now(HostIo& io);
JointVector to_joint_vector(const google::protobuf::RepeatedField<double>& values);
/// The model in force as the controller told it. Throws PeerLost where it is not sound.
LearnedModel model_in_force(HostIo& io);

struct MotionOptions {
  double speed_scale = 1.0;       ///< of the session's
  int commission_joint = 0;       ///< 1 …: that one alone turns; it is not commissioned yet
  std::function<bool()> is_over;  ///< asked each cycle; true ends the waiting (not the motion)
};
/// To a posture, then still; over one between where the straight way comes too near to something.
MotionResult drive_to(HostIo& io, const JointVector& q_real, const MotionOptions& options = {});
/// Where it is, at once (braking inside the limits): the goal becomes the present posture.
MotionResult stand_still_here(HostIo& io);

struct PoseTarget {
  wire::GoalFrame frame = wire::GOAL_FRAME_BASE;
  Pose T_X_G;                ///< in the frame named
  std::uint64_t model_revision = 0;
  double position_tolerance_m = 0.002, orientation_tolerance_rad = 0.035;
  JointVector q_seed;        ///< preferred posture, real
  double speed_scale = 1.0;
};
MotionResult drive_to(HostIo& io, const PoseTarget& target);

struct HandResult {
  double closure = 0.0, effort_permille = 0.0;
};
/// 0 open … 1 closed; waits until the fingers rest. Throws CommandFailed when refused or still moving after 8 s (more
/// where slowed).
HandResult move_hand(HostIo& io, double closure, double force_limit_permille);

}  // namespace armsight::host
