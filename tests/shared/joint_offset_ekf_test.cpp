// The filter on single looks: what it refuses, what it leaves alone, what its covariance does (specification §5.5,
// §5.6).
#include "shared/joint_offset_ekf.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>

#include "tests/shared/default_arm.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace armsight {
namespace {

using namespace test;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class JointOffsetEkfTest : public testing::Test {
 protected:
  std::mt19937 random{3};
  TrueRobot truth = true_robot(random);
  JointOffsetEkf ekf{truth.arm.chain, EkfOptions{}};

  HandPoseMeasurement look(bool flipped = false) {
    return look_at(truth, random_visible_posture(truth, random), {}, flipped, random);
  }
  void settle() {
    ekf.reset(disturbed_by(truth, EkfOptions{}, random));
    for (int k = 0; k < 5; ++k) ekf.update(look());
  }
  void expect_untouched_by(const HandPoseMeasurement& z, FusionOutcome outcome) {
    const LearnedModel model = ekf.model();
    const StateMatrix P = ekf.covariance();
    EXPECT_EQ(ekf.update(z).outcome, outcome);
    EXPECT_EQ(ekf.model().T_C_B.R, model.T_C_B.R);
    EXPECT_EQ(ekf.model().T_C_B.p, model.T_C_B.p);
    EXPECT_EQ(ekf.model().beta, model.beta);
    EXPECT_EQ(ekf.model().revision, model.revision);
    EXPECT_EQ(ekf.covariance(), P);
  }
};

TEST_F(JointOffsetEkfTest, RefusesAnOutlierAndStaysAsItWas) {
  settle();
  HandPoseMeasurement z = look();
  z.T_C_H.p.x() += 0.02;
  z.T_C_H_second.p.x() += 0.02;
  expect_untouched_by(z, FusionOutcome::kRejectedByGate);
  const FusionReport report = ekf.update(z);
  EXPECT_GT(report.cost, EkfOptions{}.cost_gate);
  EXPECT_NEAR(report.innovation.x(), 0.02, 0.003);
}

TEST_F(JointOffsetEkfTest, RefusesAFlippedLookWithoutAlternative) {
  settle();
  HandPoseMeasurement z = look(true);
  z.has_second = false;
  expect_untouched_by(z, FusionOutcome::kRejectedByGate);
}

TEST_F(JointOffsetEkfTest, TakesTheSecondSolutionWhereTheFirstIsFlipped) {
  settle();
  const HandPoseMeasurement z = look(true);
  const FusionReport report = ekf.update(z);
  EXPECT_EQ(report.outcome, FusionOutcome::kFusedSecondSolution);
  EXPECT_LT(report.innovation.tail<3>().norm(), 0.09);  // 5°: the innovation is that of the solution taken
}

TEST_F(JointOffsetEkfTest, RefusesWhatIsNoNumber) {
  settle();
  const auto spoilt = [&](auto&& spoil) {
    HandPoseMeasurement z = look();
    spoil(z);
    expect_untouched_by(z, FusionOutcome::kNotFinite);
  };
  spoilt([](auto& z) { z.T_C_H.p.y() = kNaN; });
  spoilt([](auto& z) { z.T_C_H.R(1, 2) = kNaN; });
  spoilt([](auto& z) { z.T_C_H.R *= 1.1; });
  spoilt([](auto& z) { z.T_C_H_second.p.y() = kNaN; });
  spoilt([](auto& z) { z.R_vision(0, 0) = std::numeric_limits<double>::infinity(); });
  spoilt([](auto& z) { z.q[3] = kNaN; });
  spoilt([](auto& z) { z.q = joints({0, 0, 0, 0}); });
}

TEST_F(JointOffsetEkfTest, RefusesANegativeCovariance) {
  settle();
  HandPoseMeasurement z = look();
  z.R_vision = -Matrix6::Identity();
  expect_untouched_by(z, FusionOutcome::kIllConditioned);
}

TEST_F(JointOffsetEkfTest, IgnoresASecondSolutionThatIsNotThere) {
  settle();
  HandPoseMeasurement z = look();
  z.has_second = false;
  z.T_C_H_second.p.setConstant(kNaN);
  EXPECT_EQ(ekf.update(z).outcome, FusionOutcome::kFused);
}

TEST_F(JointOffsetEkfTest, PredictAddsTheRandomWalk) {
  ekf.reset({1, truth.T_C_B, truth.beta}, StateMatrix::Identity(11, 11) * 1e-6);
  ekf.predict(30.0);
  ekf.predict(-1.0);
  ekf.predict(kNaN);
  EXPECT_NEAR(ekf.covariance()(0, 0), 1e-6 + 0.5 * 0.0002 * 0.0002, 1e-15);
  EXPECT_NEAR(ekf.covariance()(4, 4), 1e-6 + 0.5 * 0.00035 * 0.00035, 1e-15);
  EXPECT_NEAR(ekf.covariance()(10, 10), 1e-6 + 0.5 * 0.000175 * 0.000175, 1e-15);
  EXPECT_EQ(ekf.covariance()(0, 4), 0.0);
}

TEST_F(JointOffsetEkfTest, PredictedHandCovarianceDoesNotSeeTheGauge) {
  settle();
  const JointVector q = joints({0.3, -0.4, 0.5, 1.0, 0.2});
  const Matrix6 before = ekf.predicted_hand_covariance(q);
  const StateVector g = gauge_direction();
  ekf.reset(ekf.model(), ekf.covariance() + 0.1 * g * g.transpose());
  EXPECT_LT((ekf.predicted_hand_covariance(q) - before).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(JointOffsetEkf, CovarianceStaysSymmetricAndPositive) {
  std::mt19937 random(8);
  const TrueRobot truth = true_robot(random);
  JointOffsetEkf ekf(truth.arm.chain, EkfOptions{});
  ekf.reset(disturbed_by(truth, EkfOptions{}, random));
  for (int k = 0; k < 200; ++k) {
    ekf.predict(0.004);
    ekf.update(look_at(truth, random_visible_posture(truth, random), {}, false, random));
  }
  EXPECT_EQ(ekf.covariance(), StateMatrix(ekf.covariance().transpose()));
  EXPECT_EQ(ekf.covariance().llt().info(), Eigen::Success);
}

// Ten times the wide prior, and no random walk that would hide a loss: condition numbers up to 4e10.
TEST_F(JointOffsetEkfTest, KeepsItsCovariancePositiveOverAHundredThousandLooks) {
  EkfOptions options = scaled_options(10.0);
  options.max_iterations = 1;
  std::vector<HandPoseMeasurement> looks(100);
  for (HandPoseMeasurement& z : looks) z = look();
  for (const std::size_t different : {std::size_t{1}, looks.size()}) {
    JointOffsetEkf filter(truth.arm.chain, options);
    filter.reset(disturbed_by(truth, EkfOptions{}, random));
    for (int k = 0; k < 100'000; ++k) {
      filter.update(looks[static_cast<std::size_t>(k) % different]);
      if (k % 1000 != 999) continue;
      const Eigen::SelfAdjointEigenSolver<StateMatrix> P(filter.covariance(), Eigen::EigenvaluesOnly);
      ASSERT_GT(P.eigenvalues().minCoeff(), 1e-12 * P.eigenvalues().maxCoeff()) << "after look " << k + 1;
    }
  }
}

}  // namespace
}  // namespace armsight
