// The filter against a slow dense reference written from the textbook, and against its own cost.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/shared/default_arm.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace armsight {
namespace {

using namespace test;

/// A plain textbook filter on dense matrices: differences for H, the information form for P, no gate.
struct DenseReference {
  SerialChain chain;
  EkfOptions options;
  LearnedModel model;
  Eigen::MatrixXd P;

  Vector6 error(const HandPoseMeasurement& z, const Eigen::VectorXd& x) const {
    const LearnedModel m = apply_error_state(model, x);
    return pose_error(z.T_C_H, predict_T_C_H(chain, m.T_C_B, m.beta, z.q));
  }
  Eigen::MatrixXd slope(const HandPoseMeasurement& z, const Eigen::VectorXd& x0) const {
    // Richardson's extrapolation of central differences: 1e-12.
    Eigen::MatrixXd J(6, x0.size());
    for (Eigen::Index i = 0; i < x0.size(); ++i) {
      const auto central = [&](double h) -> Vector6 {
        Eigen::VectorXd above = x0, below = x0;
        above[i] += h;
        below[i] -= h;
        return (error(z, above) - error(z, below)) / (2.0 * h);
      };
      J.col(i) = (4.0 * central(1e-3) - central(2e-3)) / 3.0;
    }
    return J;
  }
  Eigen::MatrixXd look_R(const HandPoseMeasurement& z) const {
    const Eigen::MatrixXd J = predict_hand_eye(chain, model.T_C_B, model.beta, z.q).H.rightCols(chain.joint_count);
    Vector6 floor;
    floor << Vector3::Constant(options.floor_position_sigma_m), Vector3::Constant(options.floor_rotation_sigma_rad);
    return z.R_vision + options.encoder_sigma_rad * options.encoder_sigma_rad * J * J.transpose() +
           Eigen::MatrixXd(floor.cwiseAbs2().asDiagonal());
  }
  void update(const HandPoseMeasurement& z, int steps) {
    const Eigen::MatrixXd R_inverse = look_R(z).inverse(), P_inverse = P.inverse();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(P.rows());
    for (int k = 0; k < steps; ++k) {
      const Eigen::MatrixXd J = slope(z, x);
      x -= (P_inverse + J.transpose() * R_inverse * J).inverse() *
           (P_inverse * x + J.transpose() * R_inverse * error(z, x));
    }
    model = apply_error_state(model, x);
    const Eigen::MatrixXd H = predict_hand_eye(chain, model.T_C_B, model.beta, z.q).H;
    P = (P_inverse + H.transpose() * R_inverse * H).inverse();
  }
};

/// Largest difference of two filters after the same looks.
double disagreement(int max_iterations, int reference_steps) {
  std::mt19937 random(5);
  const TrueRobot truth = true_robot(random);
  EkfOptions options;
  options.max_iterations = max_iterations;
  options.cost_gate = 1e9;
  JointOffsetEkf ekf(truth.arm.chain, options);
  ekf.reset(disturbed_by(truth, options, random));
  DenseReference reference{truth.arm.chain, options, ekf.model(), ekf.covariance()};
  double worst = 0.0;
  for (int k = 0; k < 10; ++k) {
    HandPoseMeasurement z = look_at(truth, random_visible_posture(truth, random), {}, false, random);
    z.has_second = false;
    EXPECT_EQ(ekf.update(z).outcome, FusionOutcome::kFused);
    reference.update(z, reference_steps);
    worst = std::max({worst, pose_error(ekf.model().T_C_B, reference.model.T_C_B).norm(),
                      (ekf.model().beta - reference.model.beta).norm(),
                      (ekf.covariance() - reference.P).cwiseAbs().maxCoeff()});
  }
  return worst;
}

TEST(JointOffsetEkf, SequenceOfSingleStepsAgreesWithTheDenseReference) { EXPECT_LT(disagreement(1, 1), 1e-10); }

TEST(JointOffsetEkf, IteratedUpdateEndsAtTheOptimumOfTheDenseReference) { EXPECT_LT(disagreement(30, 30), 1e-7); }

TEST(JointOffsetEkf, NoUpdateEndsAboveTheCostItBeganWith) {
  // What the damping promises, where undamped steps overshoot: four times the prior, then looks that disagree with it.
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    const TrueRobot truth = true_robot(random);
    EkfOptions options = scaled_options(4.0);
    options.cost_gate = 1e12;
    JointOffsetEkf ekf(truth.arm.chain, options);
    ekf.reset(disturbed_by(truth, options, random));
    for (int k = 0; k < 10; ++k) {
      HandPoseMeasurement z = look_at(truth, random_visible_posture(truth, random), {}, k % 3 == 2, random);
      z.has_second = false;
      const DenseReference reference{truth.arm.chain, options, ekf.model(), ekf.covariance()};
      const Eigen::MatrixXd R = reference.look_R(z);
      const FusionReport report = ekf.update(z);
      EXPECT_LE(report.cost, report.innovation.dot(R.llt().solve(report.innovation)) * (1.0 + 1e-9)) << seed;
    }
  }
}

}  // namespace
}  // namespace armsight
