// The plan of looks: what it calls visible is inside the image, and its choice is better than chance.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>

#include "host/pose_planner.hpp"
#include "tests/host/app_robot.hpp"

namespace armsight::host {
namespace {

PlanProblem problem() {
  PlanProblem p;
  const ArmModel arm = test_arm();
  p.chain = arm.chain;
  p.min_rad = arm.limits.min_rad.array() + 0.1;
  p.max_rad = arm.limits.max_rad.array() - 0.1;
  p.T_C_B = test_T_C_B();
  p.T_H_M = arm.T_H_M;
  p.view = {1280, 720, 700, 700, 640, 360};
  p.P = wide_prior(5);
  return p;
}

StateMatrix inverse(const StateMatrix& A) { return A.llt().solve(StateMatrix::Identity(A.rows(), A.cols())); }

TEST(Visibility, AgreesWithThePosesOfTheSpecification) {
  // specification §7.3: looks that are visible with ≥ 90 px margin and 12–58° tilt on the default robot
  const double looks[][5] = {{0.92, -0.23, -1.05, 1.61, -0.79},
                             {0.09, 0.59, 0.25, 1.61, -0.71},
                             {1.28, -0.78, -1.29, 1.30, -0.44},
                             {1.22, 0.66, -0.82, 0.55, 0.62},
                             {0.13, 0.65, -0.09, 1.91, -0.29}};
  const PlanProblem p = problem();
  ViewLimits limits = p.limits;
  limits.min_tilt_rad -= 0.01, limits.max_tilt_rad += 0.01, limits.image_margin_px -= 3;  // printed to two digits
  for (const auto& look : looks) {
    JointVector q(5);
    q << look[0], look[1], look[2], look[3], look[4];
    const Pose T_C_M = p.T_C_B * forward_kinematics(p.chain, q) * p.T_H_M;
    EXPECT_TRUE(is_well_visible(p.view, limits, T_C_M, 0.05)) << q.transpose();
  }
}

TEST(Visibility, RefusesBehindFarFrontalAndOutside) {
  const PlanProblem p = problem();
  const auto facing = [](double tilt_rad, const Vector3& place) {
    Pose T;
    T.R = so3_exp(Vector3(std::numbers::pi, 0, 0)) * so3_exp(Vector3(0, tilt_rad, 0));
    T.p = place;
    return T;
  };
  EXPECT_TRUE(is_well_visible(p.view, p.limits, facing(0.5, {0, 0, 0.3}), 0.05));
  EXPECT_FALSE(is_well_visible(p.view, p.limits, facing(0.05, {0, 0, 0.3}), 0.05));
  EXPECT_FALSE(is_well_visible(p.view, p.limits, facing(0.5, {0, 0, 0.7}), 0.05));
  EXPECT_FALSE(is_well_visible(p.view, p.limits, facing(0.5, {0, 0, -0.3}), 0.05));
  EXPECT_FALSE(is_well_visible(p.view, p.limits, facing(0.5, {0.25, 0, 0.3}), 0.05));
  Pose away = facing(0.5, {0, 0, 0.3});
  away.R = away.R * so3_exp(Vector3(std::numbers::pi, 0, 0));
  EXPECT_FALSE(is_well_visible(p.view, p.limits, away, 0.05));
}

TEST(Visibility, CovarianceMatchesTheTableOfTheSpecification) {
  // §5.4: 50 mm marker, f = 700, 0.25 px, Z = 0.35 m, tilt 40°: xy 0.06 mm, z 0.85 mm, tilt 0.28°, roll 0.14°
  Pose T;
  T.R = so3_exp(Vector3(std::numbers::pi, 0, 0)) * so3_exp(Vector3(0, 40 * kDegree, 0));
  T.p = Vector3(0, 0, 0.35);
  const std::optional<Matrix6> P = marker_covariance(problem().view, T, 0.05, 0.25);
  ASSERT_TRUE(P);
  EXPECT_NEAR(std::sqrt((*P)(0, 0)) * 1e3, 0.06, 0.03);
  EXPECT_NEAR(std::sqrt((*P)(2, 2)) * 1e3, 0.85, 0.1);
}

TEST(PosePlanner, CandidatesAreInsideLimitsAndVisibleByProjection) {
  const PlanProblem p = problem();
  const auto candidates = visible_postures(p, 300, 0.0, {});
  ASSERT_EQ(candidates.size(), 300u);
  for (const CandidateLook& c : candidates) {
    EXPECT_TRUE((c.q_real.array() >= p.min_rad.array()).all() && (c.q_real.array() <= p.max_rad.array()).all());
    const Pose T_C_M = p.T_C_B * forward_kinematics(p.chain, c.q_real) * p.T_H_M;
    for (const double x : {-0.025, 0.025}) {
      for (const double y : {-0.025, 0.025}) {
        const Vector3 corner = T_C_M * Vector3(x, y, 0);
        const double u = 640 + 700 * corner.x() / corner.z(), v = 360 + 700 * corner.y() / corner.z();
        EXPECT_TRUE(corner.z() > 0 && u >= 90 && u <= 1190 && v >= 90 && v <= 630);
      }
    }
  }
}

TEST(PosePlanner, KeepsAwayFromPosturesThatFailed) {
  const PlanProblem p = problem();
  const JointVector failed = visible_postures(p, 1, 0.0, {}).front().q_real;
  for (const CandidateLook& c : visible_postures(p, 200, 0.0, {failed}, 0.2)) {
    EXPECT_GE((c.q_real - failed).lpNorm<Eigen::Infinity>(), 0.2);
  }
}

TEST(PosePlanner, LooksPastWhateverHidTheMarker) {
  PlanProblem p = problem();
  const Vector3 hidden =
      (p.T_C_B * forward_kinematics(p.chain, visible_postures(p, 1, 0.0, {}).front().q_real) * p.T_H_M).p;
  p.hidden = {hidden};
  const auto candidates = visible_postures(p, 200, 0.0, {});
  ASSERT_EQ(candidates.size(), 200u);
  for (const CandidateLook& c : candidates) {
    const Vector3 at = (p.T_C_B * forward_kinematics(p.chain, c.q_real) * p.T_H_M).p;
    const double angle = std::acos(at.dot(hidden) / (at.norm() * hidden.norm()));
    EXPECT_TRUE(angle > 0.149 || at.norm() < hidden.norm() - 0.029);
  }
}

TEST(PosePlanner, DOptimalChoiceBeatsEveryRandomOne) {
  const PlanProblem p = problem();
  const auto candidates = visible_postures(p, 400, 0.0, {});
  const StateMatrix prior = inverse(p.P);
  const double planned = log_det_information(candidates, prior, choose_d_optimal(candidates, prior, 5));
  std::mt19937 random(3);
  std::uniform_int_distribution<int> pick(0, static_cast<int>(candidates.size()) - 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<int> chosen;
    for (int i = 0; i < 5; ++i) chosen.push_back(pick(random));
    EXPECT_GT(planned, log_det_information(candidates, prior, chosen));
  }
}

TEST(PosePlanner, OrderShortensTravelAndKeepsTheSet) {
  const PlanProblem p = problem();
  const auto candidates = visible_postures(p, 400, 0.0, {});
  const std::vector<int> chosen = choose_d_optimal(candidates, inverse(p.P), 20);
  const JointVector start = JointVector::Zero(5);
  std::vector<int> ordered = order_by_travel(candidates, chosen, start);
  const auto length = [&](const std::vector<int>& order) {
    double sum = 0;
    JointVector at = start;
    for (const int c : order) {
      sum += (candidates[static_cast<std::size_t>(c)].q_real - at).lpNorm<Eigen::Infinity>();
      at = candidates[static_cast<std::size_t>(c)].q_real;
    }
    return sum;
  };
  EXPECT_LT(length(ordered), 0.8 * length(chosen));
  std::vector<int> sorted = chosen;
  std::sort(sorted.begin(), sorted.end());
  std::sort(ordered.begin(), ordered.end());
  EXPECT_EQ(sorted, ordered);
}

TEST(PosePlanner, SamePlanTwiceAndNoneWhereNothingIsVisible) {
  PlanProblem p = problem();
  const auto a = plan_looks(p, 5, {}, JointVector::Zero(5), false);
  const auto b = plan_looks(p, 5, {}, JointVector::Zero(5), false);
  ASSERT_EQ(a.size(), 5u);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i], b[i]);
  p.T_C_B.p.z() -= 5.0;
  EXPECT_TRUE(plan_looks(p, 5, {}, JointVector::Zero(5), false).empty());
}

TEST(PosePlanner, PosturesNearStayNearAndInsideTheLimits) {
  const JointVector lower = JointVector::Constant(3, -1.0), upper = JointVector::Constant(3, 1.0);
  JointVector q(3);
  q << 0.9, -1.4, 0.0;  // one beside its limit, one beyond
  JointVector least = upper, most = lower;
  for (int i = 0; i < 50; ++i) {
    const JointVector near = posture_near(q, 0.25, lower, upper, i);
    EXPECT_TRUE((near.array() >= lower.array()).all() && (near.array() <= upper.array()).all());
    EXPECT_LE(std::abs(near[0] - q[0]), 0.25);
    EXPECT_LE(std::abs(near[2] - q[2]), 0.25);
    least = least.cwiseMin(near);
    most = most.cwiseMax(near);
  }
  EXPECT_GT(most[2] - least[2], 0.4) << "they are spread";
  EXPECT_GT(most[0] - least[0], 0.25);
}

}  // namespace
}  // namespace armsight::host
