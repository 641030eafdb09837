// Gravity torque against the gradient of the potential energy and the figure of the specification; spring laws against
// their inverses and slopes (F-K5).
#include <gtest/gtest.h>

#include "shared/gravity.hpp"
#include "shared/kinematics.hpp"
#include "shared/spring.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using test::default_arm;
using test::general_chain;
using test::random_vector;
using test::random_within;

const Vector3 kGravity{-9.66095, -0.29581, -1.67761};

/// Specification §4.4, with a hand of 0.5 kg at its own origin.
LinkMasses ego_masses() {
  LinkMasses links;
  links[0].mass_kg = 0.600;
  links[1] = {0.643, {0, 0, 0.083}};
  links[2].mass_kg = 0.590;
  links[3] = {0.350, {0, 0, 0.077}};
  links[4].mass_kg = 0.5;
  return links;
}

TEST(Gravity, IsTheGradientOfThePotentialEnergyOfAnyChain) {
  std::mt19937 random(3);
  for (int joints = 1; joints <= kMaxJoints; ++joints) {
    const SerialChain chain = general_chain(joints, 40u + static_cast<unsigned>(joints));
    LinkMasses links;
    for (LinkMass& link : links) link = {0.2 + std::abs(random_vector(1.0, random).x()), random_vector(0.1, random)};
    JointVector q(joints);
    for (double& angle : q) angle = random_vector(1.0, random).x();
    const JointVector torque = gravity_torque(chain, links, kGravity, q);
    for (int j = 0; j < joints; ++j) {
      constexpr double kStep = 1e-3;  // five points: error of order step⁴
      const auto at = [&](double by) {
        JointVector moved = q;
        moved[j] += by;
        return potential_energy(chain, links, kGravity, moved);
      };
      const double slope = (8.0 * (at(kStep) - at(-kStep)) - (at(2 * kStep) - at(-2 * kStep))) / (12.0 * kStep);
      EXPECT_NEAR(torque[j], slope, 1e-9) << joints << " joints, joint " << j + 1;
    }
  }
}

TEST(Gravity, OfTheDefaultArmIsAsLargeAsTheSpecificationSays) {
  const ArmModel arm = default_arm();
  std::mt19937 random(5);
  JointVector largest = JointVector::Zero(5);
  for (int i = 0; i < 200'000; ++i) {
    const JointVector q = random_within(arm.limits, random);
    largest = largest.cwiseMax(gravity_torque(arm.chain, ego_masses(), kGravity, q).cwiseAbs());
  }
  const double stated[] = {4.0, 4.1, 1.2, 1.2, 0.0};  // N·m, §4.4
  for (int j = 0; j < 5; ++j) EXPECT_NEAR(largest[j], stated[j], 0.15) << "joint " << j + 1;
}

struct SpringCase {
  const char* name;
  Spring spring;
};

class SpringLaws : public testing::TestWithParam<SpringCase> {};

TEST_P(SpringLaws, InverseGivesTheDeflectionBack) {
  const Spring spring = GetParam().spring;
  for (double deflection = -0.3; deflection <= 0.3001; deflection += 0.01)
    EXPECT_NEAR(spring_deflection(spring, spring_torque(spring, deflection)), deflection, 1e-12);
}

TEST_P(SpringLaws, PullsBackAndStiffnessIsTheSlope) {
  const Spring spring = GetParam().spring;
  for (double deflection = -0.3; deflection <= 0.3001; deflection += 0.05) {
    constexpr double kStep = 1e-5;
    const double slope =
        (spring_torque(spring, deflection + kStep) - spring_torque(spring, deflection - kStep)) / (2.0 * kStep);
    EXPECT_NEAR(spring_stiffness(spring, deflection), -slope, 1e-6 * std::abs(slope));
    EXPECT_LE(spring_torque(spring, deflection) * deflection, 0.0);
  }
}

TEST_P(SpringLaws, InverseStopsAtTheStop) {
  Spring spring = GetParam().spring;
  spring.max_deflection_rad = 0.2;
  EXPECT_EQ(spring_deflection(spring, 100.0), -0.2);
  EXPECT_EQ(spring_deflection(spring, -100.0), 0.2);
}

INSTANTIATE_TEST_SUITE_P(
    Specification, SpringLaws,
    testing::Values(SpringCase{"Tan2018", {SpringLaw::kTan, 0.5, 2.0, 0.3, 0.45}},
                    SpringCase{"TanNoPreset", {SpringLaw::kTan, 0.5, 2.0, 0.0, 0.45}},
                    SpringCase{"SinhPlugin", {SpringLaw::kSinh, 0.0019, 8.9992, 0.3, 0.8}},
                    SpringCase{"SinhRobot", {SpringLaw::kSinh, 0.02, 11.0, 0.2, 0.8}}),
    [](const auto& chain) { return chain.param.name; });

// "1 N·m bends a joint by 27° (a 9, k .0019, p 0.3), 10° (p 0.6), 12.5° (a 11, k .02, p 0.2), 3° (p 0.4)".
TEST(Spring, BendsAsMuchAsTheSpecificationSays) {
  const auto bend_deg = [](double a, double k, double p) {
    return -spring_deflection({SpringLaw::kSinh, k, a, p, 2.0}, 1.0) / kDegree;
  };
  EXPECT_NEAR(bend_deg(8.9992, 0.0019, 0.3), 27.0, 0.7);
  EXPECT_NEAR(bend_deg(8.9992, 0.0019, 0.6), 10.0, 0.6);
  EXPECT_NEAR(bend_deg(11.0, 0.02, 0.2), 12.5, 0.5);
  EXPECT_NEAR(bend_deg(11.0, 0.02, 0.4), 3.0, 0.5);
}

}  // namespace
}  // namespace armsight
