#include "host/route.hpp"

#include <algorithm>

#include "host/pose_planner.hpp"

namespace armsight::host {
namespace {

constexpr int kPlaces = 400;
constexpr double kOwnSlack_m = 0.0005;  // the controller starts from its set-points, this from the readings
constexpr double kMargin_rad = 0.05;

double travel(const JointVector& a, const JointVector& b) { return (a - b).lpNorm<Eigen::Infinity>(); }

std::vector<JointVector> places_between(const RobotConfig& robot, const LearnedModel& model) {
  const JointLimits& limits = robot.arm.limits;
  const JointVector lower = limits.min_rad.cwiseMax(limits.min_rad + model.beta).array() + kMargin_rad;
  const JointVector upper = limits.max_rad.cwiseMin(limits.max_rad + model.beta).array() - kMargin_rad;
  std::vector<JointVector> places;
  for (int i = 0; i < kPlaces; ++i) places.push_back(spread_posture(lower, upper, i));
  return places;
}

}  // namespace

std::vector<JointVector> find_route(const RobotConfig& robot, const LearnedModel& model, const JointVector& q_from,
                                    const JointVector& q_to) {
  const CollisionModel& collision = robot.collision.model;
  const auto is_free = [&](const JointVector& a, const JointVector& b) {
    return check_path(collision, robot.arm.chain, a, b, kPlanSlack_m + kOwnSlack_m).is_free;
  };
  if (collision.is_empty() || is_free(q_from, q_to)) return {q_to};
  std::vector<JointVector> places = places_between(robot, model);
  const auto length = [&](const JointVector& q) { return travel(q_from, q) + travel(q, q_to); };
  std::stable_sort(places.begin(), places.end(), [&](const auto& a, const auto& b) { return length(a) < length(b); });
  for (const JointVector& q : places)
    if (is_free(q_from, q) && is_free(q, q_to)) return {q, q_to};
  return {q_to};
}

}  // namespace armsight::host
