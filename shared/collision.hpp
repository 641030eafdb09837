// Does the arm come too near to itself or to a keep-out zone? Capsules ride on the links, zones stand in the base. Real
// angles, rad, m. No heap, no throw: the tick asks it, the planners ask it, and both get the same answer.
//
// Between two postures no distance changes by more than Σ lever_i |Δq_i|, lever_i being how far what joint i moves can
// reach from its axis. So a path is checked without gaps, and what is far from everything needs no look at all.
#pragma once

#include <array>
#include <cstdint>

#include "shared/arm_model.hpp"
#include "shared/capsule_distance.hpp"

namespace armsight {

struct LinkCapsule {
  int link = 0;     ///< 0: the base; i: what moves with joint i
  Capsule capsule;  ///< in frame i of the chain (after joint i; 0: B)
};

struct CollisionModel {
  static constexpr std::size_t kMaxCapsules = 16, kMaxZones = 16, kMaxPairs = 32;
  std::array<LinkCapsule, kMaxCapsules> capsules{};
  std::array<HalfSpace, kMaxZones> half_spaces{};
  std::array<KeepOutBox, kMaxZones> boxes{};
  std::array<std::array<std::uint8_t, 2>, kMaxPairs> self_pairs{};  ///< of capsules; no others are held together
  std::size_t capsule_count = 0, half_space_count = 0, box_count = 0, pair_count = 0;
  double margin_m = 0.0;  ///< nearer than this is too near

  bool is_empty() const { return capsule_count == 0; }
};

enum class Obstacle : std::uint8_t { kNothing, kCapsule, kHalfSpace, kBox };

/// The nearest pair.
struct Clearance {
  double distance_m = 1e9;
  std::uint8_t capsule = 0, other = 0;  ///< indices; `other` among its own kind
  Obstacle obstacle = Obstacle::kNothing;
};

Clearance clearance_at(const CollisionModel& model, const SerialChain& chain, const JointVector& q_real);

/// Of each joint, whatever the posture.
JointVector levers_m(const CollisionModel& model, const SerialChain& chain);

struct PathVerdict {
  bool is_free = true;
  Clearance nearest;  ///< least on the way; where it is not free: of the first place too near
  JointVector q_there;
  double part = 0.0;  ///< of the way, 0 … 1
};

/// All of the straight line between two postures. An arm that stands too near already may leave: then nothing on the
/// way may be nearer than its start. `slack_m`: so much more than margin_m is asked for, where the start has so much.
PathVerdict check_path(const CollisionModel& model, const SerialChain& chain, const JointVector& q_from,
                       const JointVector& q_to, double slack_m = 0.0);
inline constexpr double kNoNearer_m = 1e-6;  ///< is rounding
/// What plans ask for beyond the margin, so that the watch in the tick never stops what a plan allowed.
inline constexpr double kPlanSlack_m = 0.003;

}  // namespace armsight
