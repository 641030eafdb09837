#include "host/grasp_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr int kYawSamples = 16;
constexpr int kYawRefinements = 25;
constexpr double kYawStill_rad = 1e-4;
constexpr double kMaxApproachTurn_rad = 0.9;  // more than this between pre-grasp and grasp: the elbow would flip
constexpr double kPregraspTolerance_rad = 0.6;  // five joints cannot keep the turn while drawing back
constexpr double kSag_m = 0.002;
constexpr double kForceShare = 0.3;           // of the force limit: fingers that press, not fingers that coast

// The turn about z_O that the hand's actual orientation comes nearest to: argmax trace(Rz(yaw) A) with
// A = R_O_G(0) R_actualᵀ.
double nearest_yaw(const Matrix3& R_O_G0, const Matrix3& R_O_H) {
  const Matrix3 A = R_O_H * R_O_G0.transpose();
  return std::atan2(A(1, 0) - A(0, 1), A(0, 0) + A(1, 1));
}

std::optional<IkSolution> solve(const ReachProblem& reach, const Pose& T_B_G, const JointVector& seed, int starts) {
  IkOptions options;
  options.starts = starts;
  return solve_ik(reach.chain, reach.min_rad, reach.max_rad, T_B_G, seed, options);
}

struct Attempt {
  double yaw_rad = 0.0;
  std::optional<IkSolution> ik;
};

// With the yaw free the goals are a circle, and five joints reach single points of it: let the yaw follow the posture.
Attempt settle_yaw(const ReachProblem& reach, const GraspEntry& grasp, const Pose& T_B_O, double yaw_rad) {
  Attempt attempt{yaw_rad, solve(reach, T_B_O * grasp.T_O_G(yaw_rad), reach.q_seed, 6)};
  if (!grasp.has_free_yaw) return attempt;
  for (int i = 0; i < kYawRefinements && attempt.ik; ++i) {
    const Matrix3 R_O_H = T_B_O.R.transpose() * forward_kinematics(reach.chain, attempt.ik->q).R;
    const double yaw = nearest_yaw(grasp.T_O_G(0.0).R, R_O_H);
    const std::optional<IkSolution> next = solve(reach, T_B_O * grasp.T_O_G(yaw), attempt.ik->q, 1);
    if (!next || next->orientation_error_rad > attempt.ik->orientation_error_rad + 1e-9) break;
    const bool is_settled = std::abs(std::remainder(yaw - attempt.yaw_rad, 2 * std::numbers::pi)) < kYawStill_rad;
    attempt = {yaw, next};
    if (is_settled) break;
  }
  return attempt;
}

// What is wrong with an attempt; empty: nothing, and `choice` is complete.
std::string complete(const ReachProblem& reach, const GraspObject& object, const GraspEntry& grasp, const Pose& T_B_O,
                     const Attempt& attempt, GraspChoice& choice) {
  if (!attempt.ik) return "out of reach inside the joint limits";
  if (attempt.ik->orientation_error_rad > object.orientation_tolerance_rad) {
    return "reachable only " + fixed(degrees(attempt.ik->orientation_error_rad), 1) + " deg off (tolerance " +
           fixed(degrees(object.orientation_tolerance_rad), 1) + " deg)";
  }
  choice.grasp = grasp.name;
  choice.yaw_rad = attempt.yaw_rad;
  choice.T_O_G = grasp.T_O_G(attempt.yaw_rad);
  choice.T_B_G = T_B_O * choice.T_O_G;
  choice.T_B_pregrasp = grasp.pregrasp(choice.T_B_G);
  choice.at_grasp = *attempt.ik;
  const std::optional<IkSolution> before = solve(reach, choice.T_B_pregrasp, attempt.ik->q, 1);
  if (!before) return "its pre-grasp is out of reach";
  if (before->orientation_error_rad > kPregraspTolerance_rad) {
    return "its pre-grasp is reachable only " + fixed(degrees(before->orientation_error_rad), 1) + " deg off";
  }
  if ((before->q - attempt.ik->q).lpNorm<Eigen::Infinity>() > kMaxApproachTurn_rad) {
    return "the arm would swing between pre-grasp and grasp";
  }
  const PathVerdict way = check_path(reach.collision.model, reach.chain, before->q, attempt.ik->q, kPlanSlack_m);
  if (!way.is_free)
    return to_text(reach.collision, way.nearest) + " at " + fixed(100 * way.part, 0) + " % of the approach";
  choice.at_pregrasp = *before;
  choice.travel_rad = (before->q - reach.q_seed).lpNorm<Eigen::Infinity>();
  return {};
}

}  // namespace

GraspPlan plan_grasp(const ReachProblem& reach, const GraspObject& object, const Pose& T_B_O) {
  GraspPlan plan;
  for (const GraspEntry& grasp : object.grasps) {
    const int samples = grasp.has_free_yaw ? kYawSamples : 1;
    std::string least_bad;
    bool is_offered = false;
    for (int i = 0; i < samples; ++i) {
      const double yaw = 2.0 * std::numbers::pi * i / kYawSamples;
      const Attempt attempt = settle_yaw(reach, grasp, T_B_O, samples == 1 ? 0.0 : yaw);
      GraspChoice choice;
      const std::string fault = complete(reach, object, grasp, T_B_O, attempt, choice);
      if (fault.empty()) {
        is_offered = true;
        if (!plan.best || choice.travel_rad < plan.best->travel_rad) plan.best = choice;
      } else if (least_bad.empty() || attempt.ik) {
        least_bad = fault;
      }
    }
    if (!is_offered) plan.refusals.push_back(grasp.name + ": " + least_bad);
  }
  return plan;
}

namespace {

// The joints run on the straight line between the postures; the hand does not.
bool stays_above(const ReachProblem& reach, const JointVector& q, const Vector3& up_B) {
  constexpr int kPlaces = 10;
  const double start_m = up_B.dot(forward_kinematics(reach.chain, reach.q_seed).p);
  for (int k = 1; k < kPlaces; ++k) {
    const JointVector between = reach.q_seed + (q - reach.q_seed) * k / kPlaces;
    if (up_B.dot(forward_kinematics(reach.chain, between).p) < start_m - kSag_m) return false;
  }
  return true;
}

}  // namespace

std::optional<JointVector> plan_lift(const ReachProblem& reach, const Vector3& up_B) {
  const Pose T_B_H = forward_kinematics(reach.chain, reach.q_seed);
  for (const double share : {1.0, 2.0 / 3, 1.0 / 3}) {
    const auto found = solve(reach, {T_B_H.R, T_B_H.p + share * kLift_m * up_B}, reach.q_seed, 1);
    const bool is_held_upright = found && found->orientation_error_rad < kPregraspTolerance_rad;
    if (is_held_upright && (found->q - reach.q_seed).lpNorm<Eigen::Infinity>() < kMaxApproachTurn_rad &&
        stays_above(reach, found->q, up_B))
      return found->q;
  }
  return std::nullopt;
}

GraspVerdict judge_grasp(const GraspObject& object, double hand_closure, double hand_effort_permille) {
  const bool is_kept_open = hand_closure < object.grasped_below_closure;
  const bool is_pressing = std::abs(hand_effort_permille) >= kForceShare * object.force_limit_permille;
  return is_kept_open && is_pressing ? GraspVerdict::kGrasped : GraspVerdict::kEmpty;
}

const char* to_text(GraspVerdict verdict) { return verdict == GraspVerdict::kGrasped ? "grasped" : "empty"; }

}  // namespace armsight::host
