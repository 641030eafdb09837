// What a motion would be, told without moving: the controller's own joint servo, run here from where the arm stands.
// Real angles, rad, s. The pose servo's last piece and the trim (together below a second) are not in it.
#pragma once

#include <iosfwd>
#include <string>

#include "protocol/config.hpp"

namespace armsight::host {

struct PlannedMotion {
  JointVector q_from, q_to;
  double duration_s = 0.0;
  std::string clearance;  ///< the nearest pair on the way, in words
  std::string refusal;  ///< why the controller would refuse it; empty: it would not
};

/// The trip from rest to a posture at a share of the working speed.
PlannedMotion plan_motion(const RobotConfig& robot, const LearnedModel& model, const JointVector& q_from,
                          const JointVector& q_to, double speed_scale);
/// The same to a hand pose; the posture is the one that the controller would choose.
PlannedMotion plan_motion(const RobotConfig& robot, const LearnedModel& model, const JointVector& q_from,
                          const Pose& T_B_G, double orientation_tolerance_rad, double speed_scale);
/// Start, goal and way of each joint, hand from and to, duration, verdict.
void tell(const std::string& what, const PlannedMotion& motion, const RobotConfig& robot, std::ostream& out);

}  // namespace armsight::host
