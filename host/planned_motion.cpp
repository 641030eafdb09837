#include "host/planned_motion.hpp"

#include <cmath>
#include <cstdio>
#include <ostream>

#include "host/text.hpp"
#include "shared/inverse_kinematics.hpp"
#include "shared/joint_servo.hpp"

namespace armsight::host {
namespace {

constexpr double kLongest_s = 3600.0;

// Limits of real angles with which neither they nor the readings leave the joint's.
JointLimits real_limits(const JointLimits& limits, const JointVector& beta) {
  JointLimits real = limits;
  real.min_rad = limits.min_rad.cwiseMax(limits.min_rad + beta);
  real.max_rad = limits.max_rad.cwiseMin(limits.max_rad + beta);
  return real;
}

std::string limit_refusal(const RobotConfig& robot, const JointLimits& real, const JointVector& q) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (q[i] >= real.min_rad[i] && q[i] <= real.max_rad[i]) continue;
    return robot.joint_names[static_cast<std::size_t>(i)] + " at " + fixed(degrees(q[i]), 1) + " deg: must be in [" +
           fixed(degrees(real.min_rad[i]), 1) + ", " + fixed(degrees(real.max_rad[i]), 1) + "] deg";
  }
  return {};
}

double trip_time_s(const RobotConfig& robot, const JointLimits& real, const PlannedMotion& motion, double speed_scale) {
  JointServo servo(real);
  servo.reset(motion.q_from);
  const double period_s = robot.controller.period_s;
  double t_s = 0.0;
  while (t_s < kLongest_s && !(servo.is_at_rest() && servo.setpoint().q_rad == motion.q_to)) {
    servo.step_towards(motion.q_to, speed_scale, period_s);
    t_s += period_s;
  }
  return t_s;
}

std::string place_text(const RobotConfig& robot, const JointVector& q) {
  const Vector3 p = forward_kinematics(robot.arm.chain, q).p;
  return "(" + fixed(p.x(), 3) + ", " + fixed(p.y(), 3) + ", " + fixed(p.z(), 3) + ") m";
}

}  // namespace

PlannedMotion plan_motion(const RobotConfig& robot, const LearnedModel& model, const JointVector& q_from,
                          const JointVector& q_to, double speed_scale) {
  PlannedMotion motion{q_from, q_to, 0.0, {}, {}};
  const JointLimits real = real_limits(robot.arm.limits, model.beta);
  motion.refusal = limit_refusal(robot, real, q_to);
  const PathVerdict way = check_path(robot.collision.model, robot.arm.chain, q_from, q_to, kPlanSlack_m);
  motion.clearance = to_text(robot.collision, way.nearest);
  if (motion.refusal.empty() && !way.is_free)
    motion.refusal = motion.clearance + ", at " + fixed(100 * way.part, 0) + " % of the way";
  if (motion.refusal.empty()) motion.duration_s = trip_time_s(robot, real, motion, speed_scale);
  return motion;
}

PlannedMotion plan_motion(const RobotConfig& robot, const LearnedModel& model, const JointVector& q_from,
                          const Pose& T_B_G, double orientation_tolerance_rad, double speed_scale) {
  const JointLimits real = real_limits(robot.arm.limits, model.beta);
  const auto found = solve_ik(robot.arm.chain, real.min_rad, real.max_rad, T_B_G, q_from);
  if (found && found->orientation_error_rad <= orientation_tolerance_rad)
    return plan_motion(robot, model, q_from, found->q, speed_scale);
  PlannedMotion motion{q_from, q_from, 0.0, {}, "no posture inside the limits reaches the goal"};
  if (found)
    motion.refusal =
        "the best posture misses the orientation by " + fixed(degrees(found->orientation_error_rad), 1) + " deg";
  return motion;
}

void tell(const std::string& what, const PlannedMotion& motion, const RobotConfig& robot, std::ostream& out) {
  out << what << ": hand from " << place_text(robot, motion.q_from) << " to " << place_text(robot, motion.q_to)
      << " in B\n";
  char line[128];
  for (std::size_t i = 0; i < robot.joint_names.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    std::snprintf(line, sizeof line, "  %-24s %8.2f -> %8.2f deg  (%+.2f)\n", robot.joint_names[i].c_str(),
                  degrees(motion.q_from[j]), degrees(motion.q_to[j]), degrees(motion.q_to[j] - motion.q_from[j]));
    out << line;
  }
  if (motion.refusal.empty())
    out << "  takes " << fixed(motion.duration_s, 2) << " s; " << motion.clearance << std::endl;
  else
    out << "  would be refused: " << motion.refusal << std::endl;
}

}  // namespace armsight::host
