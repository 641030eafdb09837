// The general problem: its Jacobians, its tangent, its null space in words.
#include <gtest/gtest.h>

#include "host/batch_calibration.hpp"
#include "host/closed_form_starts.hpp"
#include "host/observability.hpp"
#include "tests/host/two_chains.hpp"

namespace armsight::host {
namespace {

using namespace test_problem;

TEST(ChainProblem, ItsJacobiansAgreeWithDifferences) {
  std::mt19937 random(1);
  ChainModel model = everything_free(random);
  const NoiseModel noise{0.001, 0.001, 0.005};
  for (int k = 0; k < 20; ++k) {
    Observation z = random_observation(model, k % 2, k % 3 == 0, random);
    z.q_rate = Eigen::VectorXd::LinSpaced(7, -0.5, 1.0);
    put_in_front(model, z);
    const std::vector<char> used{1};
    const UnknownLayout layout = unknown_layout(model);
    const LookWeight W(model, z, noise);
    const Eigen::MatrixXd J = whitened_jacobian(model, {z}, used, noise, layout, false);
    for (int c = 0; c < layout.columns; ++c) {
      const double h = 1e-6;
      const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(layout.columns, c);
      const Eigen::VectorXd slope =
          W * (*residual_only(retract(model, layout, x), z) - *residual_only(retract(model, layout, -x), z)) / (2 * h);
      EXPECT_LT((slope - J.col(c)).norm(), 1e-6 * (1.0 + J.norm())) << c;
    }
  }
}

// One measurement model for batch and filter, written twice: they must not drift apart.
TEST(ChainProblem, PredictsTheDefaultArmAsTheFilterDoes) {
  const ArmModel arm = test::default_arm();
  std::mt19937 random(3);
  ChainModel model;
  model.chains.push_back({"arm", arm.chain, {0, 1, 2, 3, 4}, false});
  model.T_C_a.value = test::default_T_C_B();
  ProblemTarget hand;
  hand.chain = 0;
  hand.T_b_M.value = arm.T_H_M;
  model.targets.push_back(hand);
  const JointVector beta = test::random_between(JointVector::Constant(5, -0.1), JointVector::Constant(5, 0.1), random);
  for (int j = 0; j < 5; ++j) model.offsets.push_back({"", beta[j], Freedom::kFree, 0.0, 0.0});
  for (int k = 0; k < 20; ++k) {
    Observation z;
    z.q = test::random_between(arm.limits.min_rad, arm.limits.max_rad, random);
    const HandEyePrediction filter = predict_hand_eye(arm.chain, model.T_C_a.value, beta, JointVector(z.q));
    const Pose T_C_M = filter.T_C_H * arm.T_H_M;
    EXPECT_LT(pose_error(predicted_T_C_M(model, z), T_C_M).norm(), 1e-12);
    model.targets[0].T_b_M.value = {};
    const PosePrediction batch = predict_T_C_M(model, z, look_unknowns(model, 0));
    EXPECT_LT((batch.J.leftCols<6>() - filter.H.leftCols<6>()).norm(), 1e-12);
    EXPECT_LT((batch.J.middleCols<5>(LookUnknowns::kFirstOffset) - filter.H.rightCols<5>()).norm(), 1e-12);
    model.targets[0].T_b_M.value = arm.T_H_M;
  }
}

TEST(ChainProblem, TheSolversCostFunctionsAgreeWithItsOwnGradientChecker) {
  std::mt19937 random(2);
  ChainModel model = everything_free(random);
  for (int k = 0; k < 10; ++k) {
    Observation z = random_observation(model, k % 2, k % 3 == 0, random);
    z.q_rate = Eigen::VectorXd::LinSpaced(7, -0.5, 1.0);
    put_in_front(model, z);
    EXPECT_LT(jacobian_disagreement(model, {z}, {0.001, 0.001, 0.005}), 1e-6);
  }
}

TEST(ChainProblem, NamesWhatTheLooksCannotTell) {
  std::mt19937 random(3);
  ChainModel model = two_chain_model(random);
  model.targets.pop_back();  // head camera and hand target only
  model.targets[0].scale.freedom = Freedom::kFixed;
  std::vector<Observation> looks;
  for (int k = 0; k < 30; ++k) looks.push_back(random_observation(model, 0, false, random));
  const std::vector<char> used(looks.size(), 1);
  model.chains[0].chain.T_after[1] = Pose{};  // the camera sits on joint 2's axis frame ...
  model.chains[1].chain.T_after[4] = Pose{};  // ... and the mount on joint 5's: two plain gauges
  const Observability seen = observe(model, looks, used, {0, 0.001, 0.005});
  EXPECT_EQ(seen.parameters, 19);
  EXPECT_EQ(seen.rank, 17);
  ASSERT_EQ(seen.sentences.size(), 2u);
  const auto held = hold_unobservable_offsets(model, looks, used, {0, 0.001, 0.005});
  ASSERT_EQ(held.size(), 2u);
  EXPECT_EQ(model.offsets[1].freedom, Freedom::kFixed);
  EXPECT_EQ(model.offsets[6].freedom, Freedom::kFixed);
  EXPECT_NE((held[0] + held[1]).find("joint_1 and a turn of the camera on head about its axis (0.00, 0.00, 1.00)"),
            std::string::npos)
      << held[0] << "\n" << held[1];
}

TEST(ClosedForm, FindsBothMountsWithoutAGuess) {
  std::mt19937 random(4);
  ChainModel truth = two_chain_model(random);
  truth.targets.pop_back();
  truth.targets[0].scale.value = 1.0;
  std::vector<Observation> looks;
  for (int k = 0; k < 20; ++k) {
    looks.push_back(random_observation(truth, 0, false, random));
    looks.back().T_C_M = predicted_T_C_M(truth, looks.back());
  }
  ChainModel start = truth;
  start.T_C_a.value = {};
  start.targets[0].T_b_M.value = {};
  double best = 1e9;
  for (const auto& s : closed_form_starts(start, looks)) {
    best = std::min(best, pose_error(s.T_C_a.value, truth.T_C_a.value).norm() +
                              pose_error(s.targets[0].T_b_M.value, truth.targets[0].T_b_M.value).norm());
  }
  EXPECT_LT(best, 1e-6);
}

TEST(BatchCalibration, FindsMountsAndOffsetsAndNamesGrossOutliers) {
  std::mt19937 random(5);
  ChainModel truth = two_chain_model(random);
  truth.targets.pop_back();
  truth.targets[0].scale.value = 1.0;
  truth.targets[0].scale.freedom = Freedom::kFixed;
  std::vector<Observation> looks;
  for (int k = 0; k < 40; ++k) {
    looks.push_back(random_observation(truth, 0, false, random));
    const Pose exact = predicted_T_C_M(truth, looks.back());
    looks.back().T_C_M = {so3_exp(test::random_vector(0.002, random)) * exact.R,
                          exact.p + test::random_vector(0.0005, random)};
  }
  for (const int bad : {3, 17, 29, 31}) looks[static_cast<std::size_t>(bad)].T_C_M.R *= so3_exp(Vector3(0, 2.3, 0));
  ChainModel start = truth;
  start.T_C_a.value = {};
  start.targets[0].T_b_M.value = {};
  for (auto& offset : start.offsets) offset.value = 0.0;
  start.offsets[1].freedom = start.offsets[6].freedom = Freedom::kFixed;  // the gauges
  BatchOptions options;
  options.noise = {0, 0.0005, 0.002};
  const BatchSolution solution = solve_batch(closed_form_starts(start, looks), looks, options);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const bool is_bad = i == 3 || i == 17 || i == 29 || i == 31;
    EXPECT_EQ(solution.looks[i].used, !is_bad) << i << " " << solution.looks[i].norm;
  }
  EXPECT_NE(solution.looks[3].reason.find("deg off"), std::string::npos);
  std::mt19937 fresh(6);
  const Observation unseen = random_observation(truth, 0, false, fresh);
  const Vector6 e = pose_error(predicted_T_C_M(solution.model, unseen), predicted_T_C_M(truth, unseen));
  EXPECT_LT(e.head<3>().norm(), 0.001);
  EXPECT_LT(e.tail<3>().norm(), 0.004);
}

}  // namespace
}  // namespace armsight::host
