#include "arm_controller/link_orders.hpp"

#include <cmath>
#include <cstdio>

#include "arm_controller/motion.hpp"
#include "shared/inverse_kinematics.hpp"

namespace armsight::arm {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::optional<Refused> check_range(const char* field, double value, double above, double at_most) {
  const std::string is = std::string(field) + " = " + number(value);
  if (!std::isfinite(value)) return Refused{wire::REFUSAL_REASON_NOT_FINITE, is + ": must be finite"};
  if (value > above && value <= at_most) return std::nullopt;
  return Refused{wire::REFUSAL_REASON_OUT_OF_LIMITS,
                 is + ": must be above " + number(above) + " and at most " + number(at_most)};
}

std::optional<Refused> check_inside(const char* what, const JointVector& q, const JointLimits& limits) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (q[i] >= limits.min_rad[i] && q[i] <= limits.max_rad[i]) continue;
    return Refused{wire::REFUSAL_REASON_OUT_OF_LIMITS,
                   std::string(what) + "[" + std::to_string(i) + "] = " + number(q[i]) + " rad: must be in [" +
                       number(limits.min_rad[i]) + ", " + number(limits.max_rad[i]) + "]"};
  }
  return std::nullopt;
}

/// The straight line of the joints, from where the arm is led now. What the servo does from motion, and the last
/// centimetres of a pose goal, the tick watches by distance.
std::optional<Refused> check_way(const LinkView& view, const JointVector& q_real) {
  const CollisionConfig& collision = view.robot.collision;
  const JointVector from = view.state.q_command_rad + view.state.model.beta;
  if (collision.model.is_empty() || from.size() != q_real.size()) return std::nullopt;
  const PathVerdict way = check_path(collision.model, view.robot.arm.chain, from, q_real, kPlanSlack_m);
  if (way.is_free) return std::nullopt;
  std::string place;
  for (const double q : way.q_there) place += (place.empty() ? "" : ", ") + number(q);
  return Refused{wire::REFUSAL_REASON_TOO_NEAR, "the way there: " + to_text(collision, way.nearest) + " at " +
                                                    number(std::round(100 * way.part)) + " % of it, joints (" + place +
                                                    ") rad"};
}

/// Nobody knows where an arm would go whose signs, scales and zeros nobody has tried.
std::optional<Refused> check_commissioned(const RobotConfig& robot) {
  const std::optional<std::size_t> open = robot.first_uncommissioned();
  if (!open) return std::nullopt;
  return Refused{wire::REFUSAL_REASON_NOT_COMMISSIONED, "joint " + robot.joint_names[*open] +
                                                            " is not commissioned: host commission leads through it"};
}

std::optional<Refused> check_joint_goal(const wire::JointGoal& in, const LinkView& view, const JointVector& q) {
  if (in.commission_joint() > static_cast<std::uint32_t>(q.size()))
    return Refused{wire::REFUSAL_REASON_MALFORMED, "commission_joint = " + std::to_string(in.commission_joint()) +
                                                       ": the arm has " + std::to_string(q.size()) + " joints"};
  if (in.commission_joint() > 0) return std::nullopt;  // its limits are the tick's, from where it stands
  if (auto no = check_commissioned(view.robot)) return no;
  if (auto no = check_inside("q_real_rad", q, view.robot.arm.limits)) return no;
  if (auto no = check_inside("q_real_rad - beta", q - view.state.model.beta, view.robot.arm.limits)) return no;
  return check_way(view, q);
}

std::optional<Refused> find_posture(const LinkView& view, const JointVector& seed, Goal& goal) {
  const LearnedModel& model = view.state.model;
  const Pose T_B_G = goal.kind == GoalKind::kPoseInBase ? goal.T_X_G : model.T_C_B.inverse() * goal.T_X_G;
  JointVector min_rad, max_rad;
  Motion::reading_limits(view.robot.arm.limits, model.beta, min_rad, max_rad);
  const auto found = solve_ik(view.robot.arm.chain, min_rad + model.beta, max_rad + model.beta, T_B_G, seed);
  if (!found)
    return Refused{wire::REFUSAL_REASON_UNREACHABLE, "hand_goal: no posture inside the limits reaches (" +
                                                         number(T_B_G.p.x()) + ", " + number(T_B_G.p.y()) + ", " +
                                                         number(T_B_G.p.z()) + ") m in the base"};
  if (found->orientation_error_rad > goal.orientation_tolerance_rad)
    return Refused{wire::REFUSAL_REASON_UNREACHABLE,
                   "hand_goal: the best posture misses the orientation by " + number(found->orientation_error_rad) +
                       " rad, orientation_tolerance_rad is " + number(goal.orientation_tolerance_rad)};
  goal.q_real_rad = found->q;
  return check_way(view, found->q);
}

}  // namespace

std::optional<Refused> read_order(const wire::ModeRequest& in, ModeOrder& out) {
  if (in.mode() != wire::MODE_READY && in.mode() != wire::MODE_HOLD)
    return Refused{wire::REFUSAL_REASON_MALFORMED, "mode: only READY and HOLD can be asked for"};
  out.wish = in.mode() == wire::MODE_HOLD ? PowerWish::kHold : PowerWish::kPowerOff;
  out.clear_fault = in.clear_fault();
  out.quick_stop = in.quick_stop();
  if (out.quick_stop && out.wish == PowerWish::kHold)
    return Refused{wire::REFUSAL_REASON_MALFORMED, "quick_stop: goes with READY"};
  return std::nullopt;
}

std::optional<Refused> read_order(const wire::StiffnessCommand& in, const LinkView& view, StiffnessOrder& out) {
  const int joints = view.robot.arm.joint_count();
  if (in.permille_size() != joints)
    return Refused{wire::REFUSAL_REASON_MALFORMED, "permille: has " + std::to_string(in.permille_size()) +
                                                       " values, must have " + std::to_string(joints)};
  bool is_taken = false;
  for (int i = 0; i < joints; ++i) {
    if (in.permille(i) > 1000)
      return Refused{wire::REFUSAL_REASON_OUT_OF_LIMITS, "permille[" + std::to_string(i) + "] = " +
                                                             std::to_string(in.permille(i)) + ": must be at most 1000"};
    const auto k = static_cast<std::size_t>(i);
    const bool takes = view.robot.takes_stiffness(k);
    out.permille[k] = takes ? static_cast<std::uint16_t>(in.permille(i)) : std::uint16_t{1000};
    is_taken = is_taken || takes;
  }
  if (!is_taken) return Refused{wire::REFUSAL_REASON_WRONG_STATE, "permille: no drive of this arm can be told its stiffness"};
  return std::nullopt;
}

std::optional<Refused> read_order(const wire::JointGoal& in, const LinkView& view, Goal& out) {
  JointVector q;
  if (auto no = from_wire(in.q_real_rad(), "q_real_rad", view.robot.arm.joint_count(), q)) return no;
  if (auto no = check_range("speed_scale", in.speed_scale(), 0.0, 1.0)) return no;
  if (auto no = check_joint_goal(in, view, q)) return no;
  out.kind = GoalKind::kJoints;
  out.commission_joint = static_cast<int>(in.commission_joint()) - 1;
  out.id = in.goal();
  out.q_real_rad = q;
  out.speed_scale = in.speed_scale();
  out.T_X_G = {};
  out.model_revision = view.state.model.revision;
  return std::nullopt;
}

std::optional<Refused> read_order(const wire::PoseGoal& in, const LinkView& view, Goal& out) {
  if (auto no = check_commissioned(view.robot)) return no;
  if (auto no = from_wire(in.hand_goal(), "hand_goal", out.T_X_G)) return no;
  if (in.frame() != wire::GOAL_FRAME_BASE && in.frame() != wire::GOAL_FRAME_CAMERA)
    return Refused{wire::REFUSAL_REASON_MALFORMED, "frame: must be BASE or CAMERA"};
  if (auto no = check_range("position_tolerance_m", in.position_tolerance_m(), 0.0, 1.0)) return no;
  if (auto no = check_range("orientation_tolerance_rad", in.orientation_tolerance_rad(), 0.0, 4.0)) return no;
  if (auto no = check_range("speed_scale", in.speed_scale(), 0.0, 1.0)) return no;
  JointVector seed = view.state.q_reading_rad + view.state.model.beta;
  if (in.q_seed_rad_size() > 0)
    if (auto no = from_wire(in.q_seed_rad(), "q_seed_rad", view.robot.arm.joint_count(), seed)) return no;
  if (in.model_revision() != view.state.model.revision)
    return Refused{wire::REFUSAL_REASON_STALE_MODEL,
                   "model_revision = " + std::to_string(in.model_revision()) + ": revision " +
                       std::to_string(view.state.model.revision) + " is in force"};
  out.commission_joint = -1;
  out.id = in.goal();
  out.kind = in.frame() == wire::GOAL_FRAME_BASE ? GoalKind::kPoseInBase : GoalKind::kPoseInCamera;
  out.model_revision = in.model_revision();
  out.position_tolerance_m = in.position_tolerance_m();
  out.orientation_tolerance_rad = in.orientation_tolerance_rad();
  out.speed_scale = in.speed_scale();
  return find_posture(view, seed, out);
}

std::optional<Refused> read_order(const wire::HandCommand& in, HandOrder& out) {
  if (!std::isfinite(in.closure())) return Refused{wire::REFUSAL_REASON_NOT_FINITE, "closure: must be finite"};
  if (in.closure() < 0.0 || in.closure() > 1.0)
    return Refused{wire::REFUSAL_REASON_OUT_OF_LIMITS, "closure = " + number(in.closure()) + ": must be in [0, 1]"};
  if (in.force_limit_permille() < 1 || in.force_limit_permille() > 1000)
    return Refused{wire::REFUSAL_REASON_OUT_OF_LIMITS, "force_limit_permille: must be in [1, 1000]"};
  out.speed_scale = 1.0;
  if (in.speed_scale() != 0.0) {
    if (auto no = check_range("speed_scale", in.speed_scale(), 0.0, 1.0)) return no;
    out.speed_scale = in.speed_scale();
  }
  out.closure = in.closure();
  out.force_limit_permille = static_cast<std::uint16_t>(in.force_limit_permille());
  return std::nullopt;
}

std::optional<Refused> read_order(const wire::RecalibrationStart& in, RecalibrationOrder& out) {
  out.keep_covariance = in.keep_covariance();
  return std::nullopt;
}

std::optional<Refused> read_order(const wire::HandPose& in, const LinkView& view, Look& out) {
  HandPoseMeasurement& z = out.measurement;
  if (auto no = from_wire(in.hand_in_camera(), "hand_in_camera", z.T_C_H)) return no;
  z.has_second = in.has_hand_in_camera_second();
  if (z.has_second)
    if (auto no = from_wire(in.hand_in_camera_second(), "hand_in_camera_second", z.T_C_H_second)) return no;
  StateMatrix covariance;
  if (auto no = from_wire(in.covariance(), "covariance", 6, covariance)) return no;
  z.R_vision = covariance;
  if (in.marker_id() != static_cast<std::uint32_t>(view.robot.hand_marker.id))
    return Refused{wire::REFUSAL_REASON_IMPLAUSIBLE, "marker_id = " + std::to_string(in.marker_id()) +
                                                         ": the hand bears " +
                                                         std::to_string(view.robot.hand_marker.id)};
  if (!std::isfinite(in.reprojection_error_px()) || in.frames() == 0)
    return Refused{wire::REFUSAL_REASON_MALFORMED, "reprojection_error_px must be finite, frames at least 1"};
  if (auto no = check_time(in.arm_capture_time_ns(), "arm_capture_time_ns")) return no;
  z.q = JointVector::Zero(view.robot.arm.joint_count());
  out.capture_time = time_from_ns(in.arm_capture_time_ns());
  out.time_bound = Duration{in.time_bound_ns()};
  return std::nullopt;
}

std::optional<Refused> read_order(const wire::ModelProposal& in, const LinkView& view, Proposal& out) {
  const int joints = view.robot.arm.joint_count();
  if (auto no = from_wire(in.base_in_camera(), "base_in_camera", out.model.T_C_B)) return no;
  if (auto no = from_wire(in.beta_rad(), "beta_rad", joints, out.model.beta)) return no;
  out.has_covariance = in.covariance_size() > 0;
  if (out.has_covariance)
    if (auto no = from_wire(in.covariance(), "covariance", 6 + joints, out.P)) return no;
  out.parent_revision = in.parent_revision();
  return std::nullopt;
}

}  // namespace armsight::arm
