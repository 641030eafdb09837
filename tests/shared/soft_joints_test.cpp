// A soft arm hanging in gravity, its springs and masses 20 % other than described: the links come to where they should
// be (F-S4: ≤ 0.1°), nothing winds up, stiff joints are left alone.
#include "shared/soft_joints.hpp"

#include <gtest/gtest.h>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using test::default_arm;
using test::joints;
using test::random_within;

constexpr double kCycle_s = 0.004;

SoftArm ego() {
  SoftArm arm;
  arm.chain = default_arm().chain;
  arm.gravity_m_s2 = {-9.66095, -0.29581, -1.67761};
  arm.links[0].mass_kg = 0.600;
  arm.links[1] = {0.643, {0, 0, 0.083}};
  arm.links[2].mass_kg = 0.590;
  arm.links[3] = {0.350, {0, 0, 0.077}};
  arm.links[4].mass_kg = 0.5;
  for (std::size_t i = 0; i < 5; ++i) arm.springs[i] = {SpringLaw::kSinh, 0.02, 11.0, 0.4, 0.8};
  return arm;
}

SoftArm with_other_masses(SoftArm arm, double scale) {
  for (LinkMass& link : arm.links) link.mass_kg *= scale;
  return arm;
}

/// The true arm: links swing into the balance of spring and gravity with a time constant of 50 ms.
struct TrueArm {
  SoftArm arm;
  JointVector q;
  void step(const JointVector& equilibrium) {
    const JointVector torque = gravity_torque(arm.chain, arm.links, arm.gravity_m_s2, q);
    for (int i = 0; i < q.size(); ++i) {
      const double balance = equilibrium[i] + spring_deflection(arm.springs[static_cast<std::size_t>(i)], torque[i]);
      q[i] += kCycle_s / 0.05 * (balance - q[i]);
    }
  }
};

double error_after(double seconds, SoftJoints& soft, TrueArm& truth, const JointVector& wanted) {
  for (double t = 0.0; t < seconds; t += kCycle_s) {
    soft.step(wanted, truth.q, JointVector::Zero(5), true, kCycle_s);
    truth.step(wanted + soft.offset_rad());
  }
  return (truth.q - wanted).cwiseAbs().maxCoeff();
}

TEST(SoftJoints, BringTheLinksToATenthOfADegreeThoughTheDescriptionIsAFifthWrong) {
  std::mt19937 random(2);
  double without = 0.0;
  for (int trial = 0; trial < 40; ++trial) {
    const double scale = trial % 2 == 0 ? 1.2 : 0.8;
    const JointVector wanted = random_within(default_arm().limits, random);
    TrueArm truth{with_other_masses(ego(), scale), wanted};
    SoftJoints soft(ego());
    EXPECT_LT(error_after(4.0, soft, truth, wanted), 0.1 * kDegree) << "trial " << trial;
    for (int i = 0; i < 500; ++i) truth.step(wanted);
    without = std::max(without, (truth.q - wanted).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(without, 5.0 * kDegree) << "nothing had to be corrected";
}

TEST(SoftJoints, IntegralWaitsWhileTheArmIsUnderWay) {
  SoftJoints soft(ego());
  const JointVector wanted = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  for (int i = 0; i < 1000; ++i) soft.step(wanted, wanted.array() - 0.1, JointVector::Zero(5), false, kCycle_s);
  EXPECT_EQ(soft.integral_rad().norm(), 0.0);
  EXPECT_GT(soft.feed_forward_rad().norm(), 0.0);
}

TEST(SoftJoints, BlockedLinkWindsNothingUp) {
  SoftJoints soft(ego());
  const JointVector wanted = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  for (int i = 0; i < 20'000; ++i) soft.step(wanted, wanted.array() - 0.5, JointVector::Zero(5), true, kCycle_s);
  EXPECT_LE(soft.integral_rad().maxCoeff(), 0.2501);
  EXPECT_LE(soft.offset_rad().cwiseAbs().maxCoeff(), 0.8001);
  soft.reset();
  soft.step(wanted, wanted, JointVector::Zero(5), true, kCycle_s);
  EXPECT_EQ(soft.integral_rad().norm(), 0.0);
}

// Offsets learnt under way turn every link in gravity; the bend foreseen for it comes in as a motion would.
TEST(SoftJoints, RevisedOffsetsBlendIn) {
  const JointVector q = joints({0.9, -0.4, 0.5, 1.0, 0.2}), revised = joints({0.05, -0.08, 0.06, -0.07, 0.05});
  SoftJoints soft(ego()), fresh(ego());
  fresh.step(q, q, revised, false, kCycle_s);
  soft.step(q, q, JointVector::Zero(5), false, kCycle_s);
  const double whole = (fresh.offset_rad() - soft.offset_rad()).cwiseAbs().maxCoeff();
  ASSERT_GT(whole, 0.15 * kDegree) << "nothing to blend";
  JointVector last = soft.offset_rad(), last_step = JointVector::Zero(5);
  for (int k = 0; k < 700; ++k) {
    soft.step(q, q, revised, false, kCycle_s);
    const JointVector step = soft.offset_rad() - last;
    ASSERT_LT(step.cwiseAbs().maxCoeff(), 0.5 * kCycle_s) << "speed, cycle " << k;
    ASSERT_LT((step - last_step).cwiseAbs().maxCoeff(), 4.0 * kCycle_s * kCycle_s) << "acceleration, cycle " << k;
    last = soft.offset_rad();
    last_step = step;
  }
  EXPECT_LT((soft.offset_rad() - fresh.offset_rad()).norm(), 1e-9);
  soft.reset();
  soft.step(q, q, JointVector::Zero(5), false, kCycle_s);
  EXPECT_GT((soft.offset_rad() - fresh.offset_rad()).norm(), 0.15 * kDegree) << "no power, nothing to blend";
}

TEST(SoftJoints, StiffJointsAreLeftAlone) {
  SoftArm arm = ego();
  for (std::size_t i = 0; i < 5; ++i)
    if (i != 1) arm.springs[i].k_Nm = 0.0;
  SoftJoints soft(arm);
  const JointVector wanted = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  for (int i = 0; i < 100; ++i) soft.step(wanted, wanted.array() + 0.05, JointVector::Zero(5), true, kCycle_s);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(soft.offset_rad()[i] != 0.0, i == 1) << "joint " << i + 1;
}

}  // namespace
}  // namespace armsight
