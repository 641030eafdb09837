// From an object's pose to the posture that holds it: every grasp of the table, every sampled turn, each with the
// certificate of inverse kinematics at the grasp and at the pre-grasp; the best one wins, the others say why not.
// And the verdict afterwards, from the hand alone. Real angles, rad, m. Pure. specification F-P10, F-P11, §10 no. 9.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/grasp_table.hpp"
#include "protocol/config_collision.hpp"
#include "shared/inverse_kinematics.hpp"

namespace armsight::host {

struct GraspChoice {
  std::string grasp;
  double yaw_rad = 0.0;
  Pose T_O_G, T_B_G, T_B_pregrasp;
  IkSolution at_grasp, at_pregrasp;
  double travel_rad = 0.0;  ///< largest joint travel from the seed to the pre-grasp
};

struct GraspPlan {
  std::optional<GraspChoice> best;
  std::vector<std::string> refusals;  ///< one a grasp of the table that offers nothing: which rule, by how much
};

struct ReachProblem {
  SerialChain chain;
  JointVector min_rad, max_rad;  ///< of real angles, margin taken off
  JointVector q_seed;            ///< where the arm is
  CollisionConfig collision{};   ///< grasps that come too near to something are none
};

GraspPlan plan_grasp(const ReachProblem& reach, const GraspObject& object, const Pose& T_B_O);

/// Straight up from where the hand stands, as high as the joints reach (at most kLift_m): the hand never lower on the
/// way than at its start. nullopt: not even a third of that.
std::optional<JointVector> plan_lift(const ReachProblem& reach, const Vector3& up_B);
inline constexpr double kLift_m = 0.08;

enum class GraspVerdict { kGrasped, kEmpty };
/// Something in the fingers keeps them from closing and takes their force. Both are asked: fingers that stand still
/// half open without force have not closed at all.
GraspVerdict judge_grasp(const GraspObject& object, double hand_closure, double hand_effort_permille);
const char* to_text(GraspVerdict verdict);

}  // namespace armsight::host
