// The measurement model: specification's golden values (§9, camera-frame letters) through the base-frame form, H
// against differences, the exact gauge, and the change of letters.
#include "shared/hand_eye.hpp"

#include <gtest/gtest.h>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using test::default_arm;
using test::default_T_C_B;
using test::joints;

const JointVector kReading = joints({0.3, -0.4, 0.5, 1.0, 0.2});
const JointVector kBeta = joints({0.02, -0.03, 0.01, 0.04, -0.05});

StateVector golden_thesis_state() {
  StateVector x(11);
  x << 0.01, -0.02, 0.015, 0.03, -0.02, 0.01, 0.005, -0.01, 0.02, 0.015, -0.025;
  return x;
}

/// (5.2) with exp: the pose whose letters δt, δϑ are the first six of x.
Pose thesis_correction(const StateVector& x) { return {so3_exp(-x.segment<3>(3)), x.segment<3>(0)}; }

TEST(HandEye, ReproducesTheGoldenMeasurement) {
  const SerialChain chain = default_arm().chain;
  const Pose T_C_B = default_T_C_B();
  const StateVector x = golden_thesis_state();
  const Pose estimated = predict_T_C_H(chain, T_C_B, kBeta, kReading);
  const Pose measured = thesis_correction(x) * predict_T_C_H(chain, T_C_B, kBeta + x.tail(5), kReading);
  Vector6 h;
  h << measured.p - estimated.p, orientation_error_sine(measured.R, estimated.R);
  Vector6 golden;
  golden << 0.020691210, -0.019206534, -0.000425310, -0.019746389, 0.053658859, -0.024552332;
  EXPECT_LT((h - golden).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(HandEye, ReproducesTheGoldenMeasurementOfTheLiteralCorrection) {
  const SerialChain chain = default_arm().chain;
  const StateVector x = golden_thesis_state();
  const Pose estimated = predict_T_C_H(chain, default_T_C_B(), kBeta, kReading);
  const Pose literal{Matrix3::Identity() - skew(x.segment<3>(3)), x.segment<3>(0)};
  const Pose measured = literal * predict_T_C_H(chain, default_T_C_B(), kBeta + x.tail(5), kReading);
  Vector6 h;
  h << measured.p - estimated.p, orientation_error_sine(measured.R, estimated.R);
  Vector6 golden;
  golden << 0.020772758, -0.019016861, -0.000290609, -0.019753645, 0.053677871, -0.024561050;
  EXPECT_LT((h - golden).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(HandEye, JacobianInThesisLettersIsTheGoldenOne) {
  // w = −R̂ᵀδϑ and v = R̂ᵀ(δt + S(t̂)δϑ) to first order (§5.1), so H_thesis = H_base · ∂[v; w; ε]/∂[δt; δϑ; ε].
  const Pose T_C_B = default_T_C_B();
  const MeasurementJacobian H = predict_hand_eye(default_arm().chain, T_C_B, kBeta, kReading).H;
  Eigen::Matrix<double, 11, 11> letters = Eigen::Matrix<double, 11, 11>::Identity();
  letters.block<3, 3>(0, 0) = T_C_B.R.transpose();
  letters.block<3, 3>(0, 3) = T_C_B.R.transpose() * skew(T_C_B.p);
  letters.block<3, 3>(3, 3) = -T_C_B.R.transpose();
  Eigen::Matrix<double, 6, 11> golden;
  golden << 1, 0, 0, 0, -0.285407, 0.104017, 0, -0.205363, 0.126566, -0.024953, 0,       //
      0, 1, 0, 0.285407, 0, -0.363870, -0.247886, 0.094424, 0.035820, -0.155700, 0,      //
      0, 0, 1, -0.104017, 0.363870, 0, -0.010706, 0.153093, -0.090291, -0.096746, 0,     //
      0, 0, 0, -1, 0, 0, 1, 0, 0.416871, 0.793295, 0.593709,                             //
      0, 0, 0, 0, -1, 0, 0, -0.851129, 0.477168, 0.224511, -0.491190,                    //
      0, 0, 0, 0, 0, -1, 0, 0.524957, 0.773647, -0.565931, 0.637372;
  EXPECT_LT((H * letters - golden).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(HandEye, JacobianAgreesWithDifferences) {
  constexpr double kStep = 1e-5;
  for (int n : {1, 5, 6, 8}) {
    const SerialChain chain = test::general_chain(n, 11);
    std::mt19937 random(3);
    for (int k = 0; k < 20; ++k) {
      const LearnedModel model{
          1,
          {so3_exp(test::random_vector(1.0, random)), test::random_vector(0.3, random)},
          test::random_between(JointVector::Constant(n, -0.1), JointVector::Constant(n, 0.1), random)};
      const JointVector q = test::random_between(JointVector::Constant(n, -2.0), JointVector::Constant(n, 2.0), random);
      const HandEyePrediction prediction = predict_hand_eye(chain, model.T_C_B, model.beta, q);
      for (int i = 0; i < 6 + n; ++i) {
        const StateVector step = kStep * StateVector::Unit(6 + n, i);
        const LearnedModel above = apply_error_state(model, step), below = apply_error_state(model, -step);
        const Vector6 column = pose_error(predict_T_C_H(chain, above.T_C_B, above.beta, q),
                                          predict_T_C_H(chain, below.T_C_B, below.beta, q)) / (2.0 * kStep);
        EXPECT_LT((column - prediction.H.col(i)).cwiseAbs().maxCoeff(), 1e-9) << n << " joints, column " << i;
      }
    }
  }
}

TEST(HandEye, BaseYawAndFirstOffsetAreTheSameColumn) {
  const SerialChain chain = default_arm().chain;  // joint 1 about z_B: the gauge is (w_z, beta_1) = (1, −1)
  std::mt19937 random(5);
  for (int k = 0; k < 50; ++k) {
    const JointVector q = test::random_within(default_arm().limits, random);
    const Pose T_C_B{so3_exp(test::random_vector(1.0, random)), test::random_vector(0.3, random)};
    const MeasurementJacobian H = predict_hand_eye(chain, T_C_B, kBeta, q).H;
    EXPECT_LT((H.col(kErrorW + 2) - H.col(kErrorBeta)).norm(), 1e-14);
  }
}

TEST(HandEye, GaugeMoveLeavesPredictionsUnchanged) {
  const SerialChain chain = default_arm().chain;
  StateVector along = StateVector::Zero(11);
  along[kErrorW + 2] = 0.3;
  along[kErrorBeta] = -0.3;
  const LearnedModel model{1, default_T_C_B(), kBeta};
  const LearnedModel moved = apply_error_state(model, along);
  EXPECT_LT(pose_error(predict_T_C_H(chain, moved.T_C_B, moved.beta, kReading),
                       predict_T_C_H(chain, model.T_C_B, model.beta, kReading)).norm(), 1e-12);
}

TEST(HandEye, CameraCorrectionSpeaksTheThesisLetters) {
  const Pose before = default_T_C_B();
  const StateVector x = golden_thesis_state();
  const CameraCorrection correction = camera_correction(before, thesis_correction(x) * before);
  EXPECT_LT((correction.delta_t_m - x.segment<3>(0)).norm(), 1e-12);
  EXPECT_LT((correction.delta_theta_rad - x.segment<3>(3)).norm(), 1e-12);
}

TEST(HandEye, CovarianceOfTheHandIsThatOfItsSamples) {
  const ArmModel arm = default_arm();
  const Pose T_C_M{so3_exp(Vector3(2.0, 0.4, -0.3)), Vector3(0.05, -0.02, 0.3)};
  Matrix6 root = Matrix6::Zero();
  root.diagonal() << 1e-4, 2e-4, 1e-3, 0.01, 0.02, 0.003;
  const Matrix6 claimed = hand_covariance(T_C_M, arm.T_H_M, root * root.transpose());
  const Pose T_C_H = T_C_M * arm.T_H_M.inverse();
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  Matrix6 sampled = Matrix6::Zero();
  constexpr int kSamples = 20000;
  for (int k = 0; k < kSamples; ++k) {
    Vector6 d;
    for (int i = 0; i < 6; ++i) d[i] = root(i, i) * normal(random);
    const Pose T{so3_exp(d.tail<3>()) * T_C_M.R, T_C_M.p + d.head<3>()};
    const Vector6 e = pose_error(T * arm.T_H_M.inverse(), T_C_H);
    sampled += e * e.transpose() / kSamples;
  }
  const Vector6 scale = claimed.diagonal().cwiseSqrt();
  const Matrix6 difference =
      scale.cwiseInverse().asDiagonal() * (claimed - sampled) * scale.cwiseInverse().asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.05);
}

TEST(HandEye, CovarianceOfALookIsThatOfItsSamples) {
  const SerialChain chain = default_arm().chain;
  const NoiseModel noise{0.002, 0.001, 0.005};
  const HandEyePrediction at = predict_hand_eye(chain, default_T_C_B(), kBeta, kReading);
  const Matrix6 R_vision = 1e-7 * Matrix6::Identity();
  const Matrix6 claimed = look_covariance(R_vision, at.H.rightCols(chain.joint_count), noise);
  std::mt19937 random(10);
  std::normal_distribution<double> normal;
  Matrix6 sampled = R_vision;
  sampled.diagonal() += (Vector6() << 1e-6, 1e-6, 1e-6, 25e-6, 25e-6, 25e-6).finished();
  constexpr int kSamples = 20000;
  for (int k = 0; k < kSamples; ++k) {
    JointVector q = kReading;
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] += noise.encoder_sigma_rad * normal(random);
    const Vector6 e = pose_error(predict_T_C_H(chain, default_T_C_B(), kBeta, q), at.T_C_H);
    sampled += e * e.transpose() / kSamples;
  }
  const Vector6 scale = claimed.diagonal().cwiseSqrt();
  const Matrix6 difference =
      scale.cwiseInverse().asDiagonal() * (claimed - sampled) * scale.cwiseInverse().asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.03);
}

}  // namespace
}  // namespace armsight
