// Learn on the default arm at the geometric level: E1 in small, the gauge (E2), refusals, flips, repeatability.
#include <gtest/gtest.h>

#include "host/learn_arm.hpp"
#include "tests/shared/default_arm.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace armsight::host {
namespace {

constexpr double kLookSigma_px = 0.187;  // five frames of 0.25 px and a bias of 0.15 px (§7.1 nominal)
constexpr double kEncoderSigma = 0.102 * kDegree;

struct SimulatedRobot {
  test::TrueRobot truth;  // with the true marker mount
  ArmModel nominal;
};

SimulatedRobot simulated_robot(std::mt19937& random) {
  SimulatedRobot robot{test::true_robot(random), test::default_arm()};
  robot.truth.arm.T_H_M = {so3_exp(test::random_vector(0.3 * kDegree / std::sqrt(3.0), random)) * robot.nominal.T_H_M.R,
                           robot.nominal.T_H_M.p + test::random_vector(0.0005 / std::sqrt(3.0), random)};
  return robot;
}

LookSample look(const SimulatedRobot& robot, const JointVector& q_real, bool flipped, std::mt19937& random) {
  const auto z = test::look_at(robot.truth, q_real, {kLookSigma_px, kEncoderSigma}, flipped, random);
  const Pose mount_error = robot.truth.arm.T_H_M * robot.nominal.T_H_M.inverse();  // vision divides by the nominal one
  LookSample sample;
  sample.q_reading = z.q;
  sample.T_C_H = z.T_C_H * mount_error;
  sample.T_C_H_second = z.T_C_H_second * mount_error;
  sample.R_vision = z.R_vision;
  return sample;
}

std::vector<LookSample> looks(const SimulatedRobot& robot, int count, std::mt19937& random) {
  std::vector<LookSample> samples;
  for (int k = 0; k < count; ++k)
    samples.push_back(look(robot, test::random_visible_posture(robot.truth, random), false, random));
  return samples;
}

/// Rms hand error of a model over 40 visible postures it never saw.
std::pair<double, double> heldout_against_truth(const SimulatedRobot& robot, const LearnedModel& model,
                                                std::mt19937& random) {
  double sum_p = 0.0, sum_o = 0.0;
  for (int k = 0; k < 40; ++k) {
    const Vector6 e = test::hand_error(robot.truth, model, test::random_visible_posture(robot.truth, random));
    sum_p += e.head<3>().squaredNorm();
    sum_o += e.tail<3>().squaredNorm();
  }
  return {1e3 * std::sqrt(sum_p / 40), std::sqrt(sum_o / 40) / kDegree};
}

TEST(CalibrateArm, MeetsE1AtTheGeometricLevel) {
  std::vector<double> mm, deg, base_mm, thesis_mm;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    const SimulatedRobot robot = simulated_robot(random);
    const auto samples = looks(robot, 20, random);
    const ArmCalibration full = calibrate_arm(robot.nominal, samples, {});
    ASSERT_TRUE(full.accepted) << seed << ": " << full.why;
    CalibrationOptions base_only, thesis;
    base_only.with_offsets = false;
    thesis.cost = LearnCost::kThesis;
    std::mt19937 postures(1000 + seed), same(1000 + seed), again(1000 + seed);
    const auto [p, o] = heldout_against_truth(robot, full.model, postures);
    mm.push_back(p);
    deg.push_back(o);
    base_mm.push_back(heldout_against_truth(robot, calibrate_arm(robot.nominal, samples, base_only).model, same).first);
    thesis_mm.push_back(heldout_against_truth(robot, calibrate_arm(robot.nominal, samples, thesis).model, again).first);
  }
  const double median_mm = test::quantile(mm, 0.5), median_deg = test::quantile(deg, 0.5);
  RecordProperty("median_mm", std::to_string(median_mm));
  std::printf(
      "E1 nominal, N = 20, 40 robots: %.2f mm / %.2f deg (p95 %.2f mm, %.2f deg), base only %.1f mm, (4.6) %.2f mm\n",
      median_mm, median_deg, test::quantile(mm, 0.95), test::quantile(deg, 0.95), test::quantile(base_mm, 0.5),
      test::quantile(thesis_mm, 0.5));
  EXPECT_LE(median_mm, 0.8);
  EXPECT_LE(median_deg, 0.35);
  EXPECT_LE(test::quantile(mm, 0.95), 1.5);
  EXPECT_LE(test::quantile(deg, 0.95), 0.6);
  EXPECT_GE(test::quantile(base_mm, 0.5), 12.0 * median_mm);
  EXPECT_LE(median_mm, test::quantile(thesis_mm, 0.5));  // the ranking of §5.4
}

TEST(CalibrateArm, StatesTheGaugeAsTheSpecificationHasIt) {
  std::mt19937 random(7);
  const SimulatedRobot robot = simulated_robot(random);
  const ArmCalibration result = calibrate_arm(robot.nominal, looks(robot, 20, random), {});
  EXPECT_EQ(result.parameters, 11);
  EXPECT_EQ(result.rank, 10);
  ASSERT_EQ(result.null_vector.size(), 11);
  StateVector gauge = StateVector::Zero(11);  // §5.1: (w_z, ε_β1) = (1, −1), always
  gauge[kErrorW + 2] = 1.0;
  gauge[kErrorBeta] = -1.0;
  EXPECT_LT((result.null_vector - gauge).cwiseAbs().maxCoeff(), 1e-6);
  ASSERT_EQ(result.unobservable.size(), 1u);
  EXPECT_EQ(result.unobservable[0],
            "the offset of joint 1 and a turn of the base about its axis (0.00, 0.00, 1.00) cannot be told apart; "
            "joint 1 is held at 0");
  EXPECT_TRUE(std::isinf(result.beta_sigma_rad[0]));
  EXPECT_LT(result.beta_sigma_rad.tail<4>().maxCoeff(), 0.3 * kDegree);
  EXPECT_NEAR(std::sqrt(result.covariance(kErrorBeta, kErrorBeta)), 0.0087, 1e-6);  // its prior, honestly
}

TEST(CalibrateArm, PredictionsDoNotChangeAlongTheGauge) {
  std::mt19937 random(8);
  const SimulatedRobot robot = simulated_robot(random);
  const LearnedModel model = calibrate_arm(robot.nominal, looks(robot, 20, random), {}).model;
  StateVector gauge = StateVector::Zero(11);
  gauge[kErrorW + 2] = 0.3;
  gauge[kErrorBeta] = -0.3;
  const LearnedModel moved = apply_error_state(model, gauge);
  for (int k = 0; k < 20; ++k) {
    const JointVector q = test::random_within(robot.nominal.limits, random);
    EXPECT_LT(pose_error(predict_T_C_H(robot.nominal.chain, moved.T_C_B, moved.beta, q),
                         predict_T_C_H(robot.nominal.chain, model.T_C_B, model.beta, q)).norm(), 1e-9);
  }
}

TEST(CalibrateArm, RefusesLooksThatDoNotMoveAJointAndSaysWhich) {
  std::mt19937 random(9);
  const SimulatedRobot robot = simulated_robot(random);
  std::vector<LookSample> samples;
  const JointVector q = test::random_visible_posture(robot.truth, random);
  for (int k = 0; k < 12; ++k) {  // same shoulder and elbow, only the forearm rolls
    JointVector moved = q;
    moved[4] += 0.05 * k;
    samples.push_back(look(robot, moved, false, random));
  }
  const ArmCalibration result = calibrate_arm(robot.nominal, samples, {});
  EXPECT_FALSE(result.accepted);
  EXPECT_NE(result.why.find("add looks with it spread"), std::string::npos) << result.why;
}

TEST(CalibrateArm, RefusesTooFewLooksAndNumbersThatAreNone) {
  std::mt19937 random(10);
  const SimulatedRobot robot = simulated_robot(random);
  auto samples = looks(robot, 8, random);
  samples[2].T_C_H.p.x() = std::nan("");
  EXPECT_EQ(calibrate_arm(robot.nominal, samples, {}).why, "look 3: holds a number that is not finite");
  samples.resize(2);
  const ArmCalibration result = calibrate_arm(robot.nominal, samples, {});
  EXPECT_FALSE(result.accepted);
  EXPECT_NE(result.why.find("at least 6"), std::string::npos);
}

TEST(CalibrateArm, TakesTheOtherPlanarSolutionAndLeavesOutWrongMarkers) {
  std::mt19937 random(11);
  const SimulatedRobot robot = simulated_robot(random);
  auto samples = looks(robot, 20, random);
  for (const std::size_t flipped : {2, 9, 14}) std::swap(samples[flipped].T_C_H, *samples[flipped].T_C_H_second);
  samples[5].T_C_H.p += Vector3(0.05, 0, 0);
  samples[5].T_C_H_second.reset();
  const ArmCalibration result = calibrate_arm(robot.nominal, samples, {});
  ASSERT_TRUE(result.accepted) << result.why;
  EXPECT_TRUE(result.looks[2].second_solution && result.looks[9].second_solution && result.looks[14].second_solution);
  EXPECT_FALSE(result.looks[5].used);
  EXPECT_NE(result.looks[5].reason.find("mm"), std::string::npos);
  EXPECT_LT(heldout_against_truth(robot, result.model, random).first, 1.5);
}

TEST(CalibrateArm, KeepsTheOldModelWhereTheNewOneIsNoBetter) {
  std::mt19937 random(12);
  const SimulatedRobot robot = simulated_robot(random);
  CalibrationOptions options;
  options.previous = LearnedModel{3, robot.truth.T_C_B, robot.truth.beta};
  options.previous->T_C_B.p.x() += 0.02;
  const ArmCalibration better = calibrate_arm(robot.nominal, looks(robot, 20, random), options);
  EXPECT_TRUE(better.accepted) << better.why;
  EXPECT_GT(better.previous.rms_mm, 10.0);
  options.previous = calibrate_arm(robot.nominal, looks(robot, 80, random), {}).model;
  const ArmCalibration worse = calibrate_arm(robot.nominal, looks(robot, 7, random), options);
  EXPECT_FALSE(worse.accepted);
}

TEST(CalibrateArm, RefusesACameraThatMovedAndAMarkerOfTheWrongSize) {
  std::mt19937 random(13);
  const SimulatedRobot robot = simulated_robot(random);
  auto moved = looks(robot, 20, random);
  for (std::size_t k = 10; k < moved.size(); ++k) {
    const Pose bump{so3_exp(Vector3(0, 0.1, 0)), Vector3(0.02, 0, 0)};
    moved[k].T_C_H = bump * moved[k].T_C_H;
    moved[k].T_C_H_second.reset();
  }
  const ArmCalibration bumped = calibrate_arm(robot.nominal, moved, {});
  EXPECT_FALSE(bumped.accepted) << bumped.why << " " << bumped.heldout.rms_mm;
  EXPECT_NE(bumped.why.find("did the camera move"), std::string::npos) << bumped.why;

  auto shrunk = looks(robot, 20, random);
  for (auto& sample : shrunk) {
    Pose T_C_M = sample.T_C_H * robot.nominal.T_H_M;
    T_C_M.p *= 0.9;
    sample.T_C_H = T_C_M * robot.nominal.T_H_M.inverse();
    sample.T_C_H_second.reset();
  }
  const ArmCalibration small = calibrate_arm(robot.nominal, shrunk, {});
  EXPECT_FALSE(small.accepted) << small.why << " " << small.heldout.rms_mm;
}

TEST(CalibrateArm, GivesTheSameBitsTwice) {
  std::mt19937 random(14);
  const SimulatedRobot robot = simulated_robot(random);
  const auto samples = looks(robot, 20, random);
  const ArmCalibration a = calibrate_arm(robot.nominal, samples, {}), b = calibrate_arm(robot.nominal, samples, {});
  EXPECT_EQ(a.model.T_C_B.R, b.model.T_C_B.R);
  EXPECT_EQ(a.model.beta, b.model.beta);
  EXPECT_EQ(a.heldout.rms_mm, b.heldout.rms_mm);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(CalibrateArm, CovarianceCoversTheTruth) {
  double nees = 0.0;
  for (unsigned seed = 21; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    SimulatedRobot robot = simulated_robot(random);
    robot.truth.arm.T_H_M = robot.nominal.T_H_M;
    const ArmCalibration result = calibrate_arm(robot.nominal, looks(robot, 20, random), {});
    const JointVector q = test::random_visible_posture(robot.truth, random);
    const auto prediction =
        predict_hand_eye(robot.nominal.chain, result.model.T_C_B, result.model.beta, q - robot.truth.beta);
    const Matrix6 P = prediction.H * result.covariance * prediction.H.transpose();
    const Vector6 e = test::hand_error(robot.truth, result.model, q);
    nees += e.dot(P.inverse() * e) / 20.0;
  }
  EXPECT_LT(nees, 7.5);  // six freedoms; the floor makes the covariance cautious
  EXPECT_GT(nees, 0.5);
}

}  // namespace
}  // namespace armsight::host
