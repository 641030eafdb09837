#include "host/dry_run.hpp"

#include <cmath>
#include <ostream>

#include "host/look_planning.hpp"
#include "host/motion.hpp"
#include "host/planned_motion.hpp"
#include "host/route.hpp"
#include "host/small_verbs.hpp"
#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr double kLookMargin_rad = 0.16;

void note_state(HostIo& io, std::ostream& out) {
  out << "dry run: nothing moves; the arm is in " << to_text(io.arm().state()->mode()) << " and "
      << (io.arm().state()->is_still() ? "still" : "moving") << std::endl;
  if (io.arm().state()->mode() == wire::MODE_FAULT) out << "note: " << fault_text(io) << std::endl;
}

}  // namespace

void show_move(HostIo& io, const std::string& verb, const JointVector& q_real, const std::optional<Pose>& T_B_G,
               std::ostream& out) {
  note_state(io, out);
  const LearnedModel model = model_in_force(io);
  JointVector here = real_now(io);
  if (!T_B_G) {
    const std::vector<JointVector> route = find_route(io.robot(), model, here, q_real);
    if (route.size() > 1) {
      tell(verb + ", first, out of the way", plan_motion(io.robot(), model, here, route[0], io.speed_scale()),
           io.robot(), out);
      here = route[0];
    }
  }
  const PlannedMotion motion =
      T_B_G ? plan_motion(io.robot(), model, here, *T_B_G, kMovePoseOrientation_rad, io.speed_scale())
            : plan_motion(io.robot(), model, here, q_real, io.speed_scale());
  tell(verb, motion, io.robot(), out);
  if (!motion.refusal.empty()) throw CommandFailed(verb + ": would be refused: " + motion.refusal);
}

void show_hand(HostIo& io, double closure, double force_permille, std::ostream& out) {
  note_state(io, out);
  const double from = io.arm().state()->hand_closure();
  out << "hand: fingers from " << fixed(100 * from, 0) << " % to " << fixed(100 * closure, 0) << " % closed in "
      << fixed(std::abs(closure - from) / io.speed_scale(), 1) << " s, with at most " << fixed(force_permille / 10, 0)
      << " % of their force" << std::endl;
}

void show_looks(HostIo& io, const std::string& verb, int looks, std::ostream& out) {
  note_state(io, out);
  const RobotConfig& robot = io.robot();
  const LearnedModel model = model_in_force(io);
  const bool has_model = verb != "calibrate" && model.revision > 0;
  const PlanProblem problem = plan_problem(io, has_model ? model.T_C_B : robot.camera_hint_T_C_B,
                                           wide_prior(robot.filter, robot.arm.joint_count()), kLookMargin_rad);
  JointVector here = real_now(io);
  const auto plan = io.compute([=] { return plan_looks(problem, looks, {}, here, true); });
  if (plan.empty())
    throw CommandFailed(verb + ": no posture shows the marker to a camera where " +
                        (has_model ? "the model" : "the hint") + " says");
  int number = 0;
  for (const JointVector& q : plan) {
    tell(verb + ": look " + std::to_string(++number), plan_motion(robot, model, here, q, io.speed_scale()), robot, out);
    here = q;
  }
  out << "each look corrects the model, and the next is planned with it: only the first is certain" << std::endl;
}

}  // namespace armsight::host
