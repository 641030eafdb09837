#include "shared/collision.hpp"

#include <algorithm>

#include "shared/kinematics.hpp"

namespace armsight {
namespace {

constexpr double kLeastStep = 0.002;  // of the way: near the limit it is looked at this densely
constexpr int kMaxLooks = 2000;
constexpr double kTurning_m = 0.0005;  // of a start inside the slack: not every way away leads straight away

Capsule placed(const LinkCapsule& c, const std::array<Pose, kMaxJoints + 1>& frames) {
  const Pose& T = frames[static_cast<std::size_t>(c.link)];
  return {T * c.capsule.a_m, T * c.capsule.b_m, c.capsule.radius_m};
}

std::array<Pose, kMaxJoints + 1> frames_at(const SerialChain& chain, const JointVector& q) {
  std::array<Pose, kMaxJoints + 1> frames;
  Pose T = chain.T_B_0;
  for (int i = 0; i < chain.joint_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    T = T * Pose{so3_exp(q[i] * Vector3::UnitZ()), Vector3::Zero()} * chain.T_after[k];
    frames[k + 1] = T;
  }
  return frames;
}

void keep_nearer(Clearance& nearest, double distance_m, std::size_t capsule, std::size_t other, Obstacle obstacle) {
  if (!(distance_m < nearest.distance_m)) return;
  nearest = {distance_m, static_cast<std::uint8_t>(capsule), static_cast<std::uint8_t>(other), obstacle};
}

}  // namespace

JointVector levers_m(const CollisionModel& model, const SerialChain& chain) {
  JointVector levers = JointVector::Zero(chain.joint_count);
  for (std::size_t c = 0; c < model.capsule_count; ++c) {
    const Capsule& capsule = model.capsules[c].capsule;
    double lever = std::max(capsule.a_m.norm(), capsule.b_m.norm()) + capsule.radius_m;
    for (int i = model.capsules[c].link - 1; i >= 0; --i) {
      lever += chain.T_after[static_cast<std::size_t>(i)].p.norm();
      levers[i] = std::max(levers[i], lever);
    }
  }
  return levers;
}

Clearance clearance_at(const CollisionModel& model, const SerialChain& chain, const JointVector& q_real) {
  Clearance nearest;
  if (model.is_empty()) return nearest;
  const std::array<Pose, kMaxJoints + 1> frames = frames_at(chain, q_real);
  std::array<Capsule, CollisionModel::kMaxCapsules> at;
  for (std::size_t i = 0; i < model.capsule_count; ++i) {
    at[i] = placed(model.capsules[i], frames);
    if (model.capsules[i].link == 0) continue;  // what does not move is where it is
    for (std::size_t k = 0; k < model.half_space_count; ++k)
      keep_nearer(nearest, distance_m(at[i], model.half_spaces[k]), i, k, Obstacle::kHalfSpace);
    for (std::size_t k = 0; k < model.box_count; ++k)
      keep_nearer(nearest, distance_m(at[i], model.boxes[k]), i, k, Obstacle::kBox);
  }
  for (std::size_t p = 0; p < model.pair_count; ++p) {
    const auto [x, y] = model.self_pairs[p];
    keep_nearer(nearest, distance_m(at[x], at[y]), x, y, Obstacle::kCapsule);
  }
  return nearest;
}

PathVerdict check_path(const CollisionModel& model, const SerialChain& chain, const JointVector& q_from,
                       const JointVector& q_to, double slack_m) {
  PathVerdict verdict;
  verdict.q_there = q_from;
  if (model.is_empty()) return verdict;
  const JointVector way = q_to - q_from;
  const double travel_m = levers_m(model, chain).dot(way.cwiseAbs());
  const double at_start = clearance_at(model, chain, q_from).distance_m;
  const double limit_m = at_start < model.margin_m
                             ? at_start - kNoNearer_m
                             : std::clamp(at_start - kTurning_m, model.margin_m, model.margin_m + slack_m);
  double part = 0.0;
  for (int look = 0; look < kMaxLooks; ++look) {
    const Clearance here = clearance_at(model, chain, q_from + part * way);
    if (here.distance_m < verdict.nearest.distance_m) {
      verdict.nearest = here;
      verdict.part = part;
      verdict.q_there = q_from + part * way;
    }
    if (here.distance_m < limit_m) {
      verdict.is_free = false;
      return verdict;
    }
    if (part >= 1.0) return verdict;
    const double free_part = travel_m > 0.0 ? (here.distance_m - limit_m) / travel_m : 1.0;
    part = std::min(1.0, part + std::max(kLeastStep, free_part));
  }
  return verdict;
}

}  // namespace armsight
