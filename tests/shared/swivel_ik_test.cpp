// The closed form finds every reachable pose and proves its orientation error the least; a general search, which knows
// nothing of shoulders and elbows, is the witness.
#include "shared/swivel_ik.hpp"

#include <gtest/gtest.h>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using namespace test;

struct Range {
  JointVector min, max;
};

const Range kWide{JointVector::Constant(5, -2.0), JointVector::Constant(5, 2.0)};

Range default_range() { return {default_arm().limits.min_rad, default_arm().limits.max_rad}; }

std::optional<IkSolution> solve(const SerialChain& chain, const Range& range, const Pose& goal,
                                const JointVector& seed) {
  const auto arm = swivel_arm(chain);
  EXPECT_TRUE(arm);
  return arm ? solve_swivel_ik(chain, *arm, range.min, range.max, goal, seed, 1e-5) : std::nullopt;
}

/// The same arm 5 nm off: no closed form any more.
SerialChain bent(SerialChain chain) {
  chain.T_after[0].p.x() += 5e-9;
  return chain;
}

/// The default arm as another would describe it: elsewhere in the world, with its zeros elsewhere.
SerialChain described_otherwise() {
  SerialChain chain = default_arm().chain;
  chain.T_B_0 = {so3_exp({0.3, -1.0, 0.7}), {0.1, 0.2, -0.3}};
  for (std::size_t i = 0; i < 5; ++i)
    chain.T_after[i] = Pose{so3_exp({0, 0, 0.2 * static_cast<double>(i) - 0.5}), Vector3::Zero()} * chain.T_after[i];
  chain.T_after[4].R = chain.T_after[4].R * so3_exp({0.4, 0.1, -0.2});
  return chain;
}

void expect_all_solved(const SerialChain& chain, const Range& range) {
  std::mt19937 random(11);
  for (int k = 0; k < 3000; ++k) {
    const Pose goal = forward_kinematics(chain, random_between(range.min, range.max, random));
    const auto solution = solve(chain, range, goal, random_between(range.min, range.max, random));
    ASSERT_TRUE(solution) << k;
    EXPECT_LT(solution->position_error_m, 1e-9);
    EXPECT_LT(solution->orientation_error_rad, 1e-6);
    EXPECT_GE((solution->q - range.min).minCoeff(), 0.0);
    EXPECT_GE((range.max - solution->q).minCoeff(), 0.0);
  }
}

TEST(SwivelIk, SolvesEveryReachablePose) {
  expect_all_solved(default_arm().chain, kWide);
  expect_all_solved(default_arm().chain, default_range());
  expect_all_solved(described_otherwise(), kWide);
}

TEST(SwivelIk, LeavesLessOrientationErrorThanAnySearch) {
  const SerialChain chain = default_arm().chain, other = bent(chain);
  const Range range = default_range();
  std::mt19937 random(12);
  int agreeing = 0, at_a_limit = 0;
  for (int k = 0; k < 300; ++k) {
    const JointVector q = random_between(range.min, range.max, random);
    Pose goal = forward_kinematics(chain, q);
    goal.R = so3_exp(0.5 * random_vector(1.0, random).normalized()) * goal.R;
    const auto ours = solve(chain, range, goal, q);
    const auto searched =
        solve_ik(other, range.min, range.max, goal, q, {.position_tolerance_m = 1e-8, .limit_margin_rad = 0.0});
    ASSERT_TRUE(ours);
    if (!searched) continue;
    if (searched->orientation_error_rad < ours->orientation_error_rad + 1e-3) ++agreeing;
    EXPECT_LE(ours->orientation_error_rad, searched->orientation_error_rad + 1e-4) << k;
    const double clearance = std::min((ours->q - range.min).minCoeff(), (range.max - ours->q).minCoeff());
    if (clearance < 1e-9) ++at_a_limit;
  }
  EXPECT_GT(agreeing, 270);
  EXPECT_GT(at_a_limit, 60);  // the edges have been looked at, too
}

TEST(SwivelIk, TakesThePostureNearestToTheSeed) {
  const SerialChain chain = default_arm().chain;
  std::mt19937 random(13);
  for (int k = 0; k < 300; ++k) {
    const JointVector q = random_between(kWide.min, kWide.max, random);
    const auto solution = solve(chain, kWide, forward_kinematics(chain, q), q);
    ASSERT_TRUE(solution);
    EXPECT_LT((solution->q - q).norm(), 1e-6);
  }
}

TEST(SwivelIk, AnswersAtTheSingularPostures) {
  const SerialChain chain = default_arm().chain;
  const Range range{JointVector::Constant(5, -2.0), JointVector::Constant(5, 2.0)};
  const double quarter = std::numbers::pi / 2.0;
  for (const JointVector& q : {joints({0, 0, 0, 0, 0}),                 // stretched: joints 3 and 5 on one line
                               joints({0.4, -0.3, 0.2, 0, 0.5}),        // stretched elsewhere
                               joints({0.3, -quarter, 0.4, 1.0, 0.2}),  // upper arm along axis 1
                               joints({0.3, quarter, 0.4, 0, 0.2})}) {  // both
    const Pose goal = forward_kinematics(chain, q);
    for (const JointVector& seed : {q, joints({0.1, 0.2, 0.3, 0.4, 0.5})}) {
      const auto solution = solve(chain, range, goal, seed);
      ASSERT_TRUE(solution) << q.transpose();
      EXPECT_LT(solution->position_error_m, 1e-8);
      EXPECT_LT(solution->orientation_error_rad, 1e-5);
    }
  }
}

TEST(SwivelIk, RefusesWhatIsOutOfReach) {
  const SerialChain chain = default_arm().chain;
  const JointVector seed = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  Pose goal = forward_kinematics(chain, seed);
  goal.p *= 0.3531 / goal.p.norm();
  EXPECT_FALSE(solve(chain, kWide, goal, seed));
  goal.p *= 0.353005 / 0.3531;  // beyond by less than the tolerance
  EXPECT_TRUE(solve(chain, kWide, goal, seed));
  goal.p *= 0.1 / 0.353005;  // the elbow does not fold that far
  EXPECT_FALSE(solve(chain, kWide, goal, seed));
  goal.p.setZero();
  EXPECT_FALSE(solve(chain, kWide, goal, seed));
}

TEST(SwivelIk, KnowsItsArms) {
  EXPECT_TRUE(swivel_arm(default_arm().chain));
  EXPECT_TRUE(swivel_arm(described_otherwise()));
  EXPECT_FALSE(swivel_arm(bent(default_arm().chain)));
  EXPECT_FALSE(swivel_arm(general_chain(5, 1)));
  EXPECT_FALSE(swivel_arm(general_chain(6, 1)));
  for (std::size_t i = 0; i < 5; ++i) {
    SerialChain chain = default_arm().chain;
    chain.T_after[i].R = chain.T_after[i].R * so3_exp({1e-6, 0, 0});
    EXPECT_EQ(swivel_arm(chain).has_value(), i == 4) << i;  // behind the last joint any turn is the hand's own
    chain = default_arm().chain;
    chain.T_after[i].p += Vector3(1e-6, 1e-6, 1e-6);
    EXPECT_FALSE(swivel_arm(chain)) << i;
  }
}

}  // namespace
}  // namespace armsight
