#include "host/first_sight.hpp"

#include <ostream>

#include "host/look_planning.hpp"
#include "host/motion.hpp"
#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr int kHintPostures = 4;
constexpr int kSweepPostures = 120;
constexpr double kSweepMargin_rad = 0.15;  // joint offsets before Learn: up to 8 degrees
constexpr Duration kGlancePeriod = std::chrono::milliseconds(150);  // 4 degrees of travel at working speed

std::vector<JointVector> hint_postures(HostIo& io) {
  EkfOptions unsure = io.robot().filter;
  unsure.prior_position_sigma_m = 0.05;
  unsure.prior_rotation_sigma_rad = 0.15;
  unsure.prior_beta_sigma_rad = 0.08;
  const int joints = io.robot().arm.joint_count();
  const PlanProblem problem =
      plan_problem(io, io.robot().camera_hint_T_C_B, wide_prior(unsure, joints), kSweepMargin_rad);
  const JointVector start = reading_now(io);
  return io.compute([=] { return plan_looks(problem, kHintPostures, {}, start, true); });
}

// Drives to q and glances at single frames on the way; where the marker came into view, it turns back to there and
// answers true.
bool drive_glancing(HostIo& io, Looker& looker, const JointVector& q) {
  Time last_request = io.now() - kGlancePeriod;
  std::optional<Time> seen_at;
  MotionOptions options;
  options.is_over = [&] {
    if (io.frame() && looker.sees(io.frame()->gray_or_bgr)) {
      seen_at = io.frame()->capture_time;
      return true;
    }
    if (io.now() - last_request >= kGlancePeriod) {
      io.camera().request(1);
      last_request = io.now();
    }
    return false;
  };
  drive_to(io, q, options);  // refused or stopped short: the next posture may do
  if (!seen_at) return false;
  stand_still_here(io);
  const auto at = io.arm().alignment().to_arm(*seen_at);
  if (!at) return true;
  const Duration slack = std::chrono::milliseconds(15);
  if (const auto reading = io.arm().mean_reading(at->arm_time - slack, at->arm_time + slack)) {
    const JointVector back =
        Eigen::Map<const Eigen::VectorXd>(reading->data(), static_cast<Eigen::Index>(reading->size()));
    drive_to(io, back + model_in_force(io).beta);
  }
  return true;
}

}  // namespace

FirstSight find_marker(HostIo& io, Looker& looker, int frames, std::ostream& progress) {
  FirstSight sight;
  const auto is_found = [&] {
    if (looker.look(1, std::nullopt).why == kNotSeen) return false;
    sight.taken = looker.look(frames, std::nullopt);
    return sight.taken.look && sight.taken.q_reading.size() > 0;
  };
  // A glance on the way that came to nothing does not cost the posture it was on the way to.
  const auto is_found_towards = [&](const JointVector& q) {
    ++sight.stops;
    if (drive_glancing(io, looker, q)) {
      if (is_found()) return true;
      drive_to(io, q);
    }
    return is_found();
  };
  progress << "search: looking for marker " << io.robot().hand_marker.id << " on the hand" << std::endl;
  if (is_found()) return sight;
  for (const JointVector& q : hint_postures(io)) {
    if (is_found_towards(q)) return sight;
  }
  progress << "search: nothing where the hint says; sweeping the joint space" << std::endl;
  const JointVector lower = io.robot().arm.limits.min_rad.array() + kSweepMargin_rad;
  const JointVector upper = io.robot().arm.limits.max_rad.array() - kSweepMargin_rad;
  for (int i = 0; i < kSweepPostures; ++i) {
    if (is_found_towards(spread_posture(lower, upper, i))) return sight;
    if ((i + 1) % 10 == 0) progress << "search: " << i + 1 << " postures, marker not seen yet" << std::endl;
  }
  throw CommandFailed("search: marker " + std::to_string(io.robot().hand_marker.id) + " not seen from " +
                      std::to_string(sight.stops) +
                      " postures: is it on the hand, is the camera looking at the arm, is there light?");
}

}  // namespace armsight::host
