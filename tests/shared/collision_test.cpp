// Distances against values worked out by hand and against dense sampling; paths against dense sampling of the line.
#include "shared/collision.hpp"

#include <gtest/gtest.h>

#include "shared/kinematics.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::test {
namespace {

constexpr double kFine = 1e-12;

TEST(CapsuleDistance, OfSegmentsInEveryPositionToEachOther) {
  const Vector3 o(0, 0, 0), x(1, 0, 0);
  EXPECT_NEAR(segment_distance_m(o, x, {0.5, -1, 2}, {0.5, 1, 2}), 2.0, kFine);         // crossing
  EXPECT_NEAR(segment_distance_m(o, x, {0.2, 3, 0}, {0.7, 3, 0}), 3.0, kFine);          // parallel, beside
  EXPECT_NEAR(segment_distance_m(o, x, {3, 0, 4}, {5, 0, 4}), std::sqrt(20.0), kFine);  // parallel, apart
  EXPECT_NEAR(segment_distance_m(o, x, {2, 1, 0}, {3, 9, 0}), std::sqrt(2.0), kFine);   // end to end
  EXPECT_NEAR(segment_distance_m(o, o, {0, 3, 4}, {0, 3, 4}), 5.0, kFine);              // two points
  EXPECT_NEAR(segment_distance_m(o, o, {-1, 2, 0}, {1, 2, 0}), 2.0, kFine);
  EXPECT_NEAR(segment_distance_m({-1, 2, 0}, {1, 2, 0}, o, o), 2.0, kFine);
  EXPECT_NEAR(segment_distance_m(o, x, {0.5, -1, 0}, {0.5, 1, 0}), 0.0, kFine);  // through each other
  const Capsule a{o, x, 0.3}, b{{0.5, -1, 2}, {0.5, 1, 2}, 0.2};
  EXPECT_NEAR(distance_m(a, b), 1.5, kFine);
}

TEST(CapsuleDistance, OfHalfSpaceIsThatOfTheLowerEnd) {
  const HalfSpace table{Vector3::UnitZ(), -0.2};
  EXPECT_NEAR(distance_m({{0, 0, 1}, {5, 0, 0.1}, 0.05}, table), 0.25, kFine);
  EXPECT_NEAR(distance_m({{0, 0, -0.3}, {0, 0, 1}, 0.05}, table), -0.15, kFine);
}

TEST(CapsuleDistance, OfBoxFromFaceEdgeCornerAndInside) {
  const Vector3 half(1, 2, 3);
  EXPECT_NEAR(segment_box_distance_m({0, 0, 5}, {0.5, 1, 4}, half), 1.0, kFine);                        // above a face
  EXPECT_NEAR(segment_box_distance_m({-9, 4, 5}, {9, 4, 5}, half), std::sqrt(8.0), kFine);              // along an edge
  EXPECT_NEAR(segment_box_distance_m({2, 3, 4}, {3, 4, 5}, half), std::sqrt(3.0), kFine);               // off a corner
  EXPECT_NEAR(segment_box_distance_m({-9, 0, 0}, {9, 0, 0}, half), 0.0, kFine);                         // through it
  EXPECT_NEAR(segment_box_distance_m({3, 0, 0}, {0, 4, 0}, half), (4 * 1 + 3 * 2 - 12) / -5.0, kFine);  // past an edge
  const double kHalfRoot = std::sqrt(0.5);  // the corner (-1, 2) is nearest
  const KeepOutBox turned{{so3_exp(Vector3(0, 0, std::numbers::pi / 4)), {10, 0, 0}}, half};
  EXPECT_NEAR(distance_m({{0, 0, 0}, {0, 0, 1}, 0.5}, turned), std::hypot(10 - 3 * kHalfRoot, kHalfRoot) - 0.5, 1e-9);
}

double sampled_box_m(const Vector3& a, const Vector3& b, const Vector3& half) {
  double least = 1e9;
  for (int i = 0; i <= 2000; ++i)
    least = std::min(least, ((a + (b - a) * i / 2000.0).cwiseAbs() - half).cwiseMax(0.0).norm());
  return least;
}

double sampled_segments_m(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  double least = 1e9;
  for (int i = 0; i <= 100; ++i)
    for (int k = 0; k <= 100; ++k) least = std::min(least, (a + (b - a) * i / 100.0 - c - (d - c) * k / 100.0).norm());
  return least;
}

TEST(CapsuleDistance, IsNeverAboveASampleAndNeverFarBelow) {
  std::mt19937 random(3);
  for (int n = 0; n < 400; ++n) {
    const Vector3 a = random_vector(1.0, random), b = n % 7 ? random_vector(1.0, random) : a;
    const Vector3 c = random_vector(1.0, random), d = n % 5 ? random_vector(1.0, random) : Vector3(c + (b - a));
    const Vector3 half = random_vector(0.5, random).cwiseAbs();
    const double of_box = sampled_box_m(a, b, half), box = segment_box_distance_m(a, b, half);
    EXPECT_LE(box, of_box + kFine) << n;
    EXPECT_GE(box, of_box - (b - a).norm() / 4000) << n;
    const double of_segments = sampled_segments_m(a, b, c, d), segments = segment_distance_m(a, b, c, d);
    EXPECT_LE(segments, of_segments + kFine) << n;
    EXPECT_GE(segments, of_segments - ((b - a).norm() + (d - c).norm()) / 200) << n;
    EXPECT_NEAR(segments, segment_distance_m(d, c, b, a), 1e-9) << "order says nothing";
  }
}

/// Forearm and hand, upper arm, a table in front.
CollisionModel small_model() {
  CollisionModel m;
  m.capsules[0] = {3, {{0, 0.168, 0}, {0, 0.06, 0}, 0.03}};
  m.capsules[1] = {5, {{0, 0.08, 0}, {0, -0.1, 0}, 0.03}};
  m.capsule_count = 2;
  m.boxes[0] = {{Matrix3::Identity(), {-0.3, -0.3, 0}}, {0.1, 0.15, 0.2}};
  m.box_count = 1;
  m.self_pairs[0] = {0, 1};
  m.pair_count = 1;
  m.margin_m = 0.01;
  return m;
}

TEST(Collision, CapsulesRideOnTheirLinks) {
  const ArmModel arm = default_arm();
  const JointVector q = joints({0.3, -0.4, 0.5, 1.2, -0.7});
  CollisionModel m = small_model();
  m.box_count = m.pair_count = 0;
  m.capsules[0] = m.capsules[1];
  m.capsule_count = 1;
  const Pose T_B_H = forward_kinematics(arm.chain, q);
  m.half_spaces[0] = {Vector3::UnitX(), -1.0};
  m.half_space_count = 1;
  const double lower = std::min((T_B_H * Vector3(0, 0.08, 0)).x(), (T_B_H * Vector3(0, -0.1, 0)).x());
  const Clearance c = clearance_at(m, arm.chain, q);
  EXPECT_NEAR(c.distance_m, lower + 1.0 - 0.03, kFine);
  EXPECT_EQ(c.obstacle, Obstacle::kHalfSpace);
}

TEST(Collision, NoDistanceChangesByMoreThanTheLeversAllow) {
  const ArmModel arm = default_arm();
  const CollisionModel m = small_model();
  const JointVector levers = levers_m(m, arm.chain);
  EXPECT_NEAR(levers[4], std::max(0.08, 0.1) + 0.03 + 0.185, kFine) << "the forearm's frame is 0.185 m on";
  std::mt19937 random(6);
  double fullest = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const JointVector q = random_within(arm.limits, random);
    JointVector step = JointVector::Zero(5);
    step[n % 5] = n % 2 ? 0.05 : -0.05;
    const double change = clearance_at(m, arm.chain, q + step).distance_m - clearance_at(m, arm.chain, q).distance_m;
    fullest = std::max(fullest, std::abs(change) / levers.dot(step.cwiseAbs()));
  }
  EXPECT_LE(fullest, 1.0);
  EXPECT_GT(fullest, 0.7) << "nor by much less";
}

TEST(Collision, APathIsRefusedExactlyWhereSamplingFindsItTooNear) {
  const ArmModel arm = default_arm();
  const CollisionModel m = small_model();
  std::mt19937 random(4);
  int refused = 0, passed = 0;
  for (int n = 0; n < 200; ++n) {
    const JointVector from = random_within(arm.limits, random), to = random_within(arm.limits, random);
    if (clearance_at(m, arm.chain, from).distance_m < m.margin_m + 0.001) continue;
    double least = 1e9;
    for (int i = 0; i <= 250; ++i)
      least = std::min(least, clearance_at(m, arm.chain, from + (to - from) * i / 250.0).distance_m);
    const PathVerdict verdict = check_path(m, arm.chain, from, to);
    if (verdict.is_free) EXPECT_GT(least, m.margin_m - 1e-4) << n;
    else EXPECT_LT(least, m.margin_m + 0.002) << n;
    if (!verdict.is_free) {
      EXPECT_LT(clearance_at(m, arm.chain, verdict.q_there).distance_m, m.margin_m);
    }
    ++(verdict.is_free ? passed : refused);
  }
  EXPECT_GT(refused, 20);
  EXPECT_GT(passed, 20);
}

TEST(Collision, AnArmThatStandsTooNearMayLeaveAndNotComeNearer) {
  const ArmModel arm = default_arm();
  CollisionModel m = small_model();
  m.box_count = 0;
  m.half_space_count = 1;
  m.half_spaces[0] = {Vector3::UnitX(), 0.0};  // x0 is up: a table under the hanging arm
  const JointVector low = joints({0, 0, 0, 0.6, 0}), high = joints({0, 0, 0, 2.0, 0}),
                    lower = joints({0, 0, 0, 0.3, 0});
  m.half_spaces[0].offset_m = clearance_at(m, arm.chain, low).distance_m - 0.004;
  ASSERT_LT(clearance_at(m, arm.chain, low).distance_m, m.margin_m);
  EXPECT_TRUE(check_path(m, arm.chain, low, high).is_free);
  EXPECT_FALSE(check_path(m, arm.chain, low, lower).is_free);
  EXPECT_FALSE(check_path(m, arm.chain, high, low).is_free);
}

TEST(Collision, NothingDescribedIsNothingRefused) {
  const ArmModel arm = default_arm();
  const PathVerdict verdict = check_path({}, arm.chain, arm.limits.min_rad, arm.limits.max_rad);
  EXPECT_TRUE(verdict.is_free);
  EXPECT_EQ(verdict.nearest.obstacle, Obstacle::kNothing);
}

}  // namespace
}  // namespace armsight::test
