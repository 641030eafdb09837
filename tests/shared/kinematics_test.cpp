// Golden values of specification §9, closed forms of §4.2, and the Jacobian against differences on other chains.
#include "shared/kinematics.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

using test::default_arm;
using test::general_chain;
using test::joints;
using test::random_between;

constexpr double kNineDigits = 1e-9;

Jacobian difference_jacobian(const SerialChain& chain, const JointVector& q) {
  constexpr double kStep = 1e-5;
  Jacobian J(6, chain.joint_count);
  for (int i = 0; i < chain.joint_count; ++i) {
    JointVector above = q, below = q;
    above[i] += kStep;
    below[i] -= kStep;
    J.col(i) = pose_error(forward_kinematics(chain, above), forward_kinematics(chain, below)) / (2.0 * kStep);
  }
  return J;
}

TEST(Kinematics, ReproducesTheGoldenPose) {
  const Pose T = forward_kinematics(default_arm().chain, joints({0.3, -0.4, 0.5, 1.0, 0.2}));
  Matrix3 R;
  R << 0.994162530, 0.107111046, -0.012964835, -0.079203491, 0.806117792, 0.586430654, 0.073264386, -0.581980523,
      0.809895673;
  EXPECT_LT((T.R - R).cwiseAbs().maxCoeff(), kNineDigits);
  EXPECT_LT((T.p - Vector3(-0.167642637, -0.194860070, 0.173088678)).cwiseAbs().maxCoeff(), kNineDigits);
}

TEST(Kinematics, ReproducesTheGoldenJacobian) {
  const HandKinematics hand = hand_kinematics(default_arm().chain, joints({0.3, -0.4, 0.5, 1.0, 0.2}));
  Eigen::Matrix<double, 6, 5> J;
  J << 0.194860070, -0.165357930, 0.028768709, 0.180730419, 0,  //
      -0.167642637, -0.051151202, 0.087021622, -0.035914139, 0,  //
      0, -0.217740217, 0.125830885, -0.016483029, 0,             //
      0, 0.295520207, -0.879923176, 0.184803203, -0.107111046,   //
      0, -0.955336489, -0.272192135, 0.559005780, -0.806117792,  //
      1, 0, 0.389418342, 0.808307067, 0.581980523;
  EXPECT_LT((hand.J - J).cwiseAbs().maxCoeff(), kNineDigits);
}

TEST(Kinematics, ReproducesTheGoldenPositions) {
  const SerialChain chain = default_arm().chain;
  const double quarter = std::numbers::pi / 2.0;
  const struct {
    JointVector q;
    Vector3 p;
  } golden[] = {
      {joints({0.5, -0.3, 0.2, 1.2, -0.4}), {-0.107148929, -0.251098995, 0.102183951}},
      {joints({1.0, -0.6, -0.8, 0.7, 0.9}), {-0.094225765, -0.300428003, 0.104192661}},
      {joints({0, 0, 0, 0, 0}), {-0.353, 0, 0}},
      {joints({quarter, 0, 0, 0, 0}), {0, -0.353, 0}},
      {joints({0, quarter, 0, 0, 0}), {0, 0, -0.353}},
      {joints({0, 0, quarter, 0, 0}), {-0.353, 0, 0}},
      {joints({0, 0, 0, quarter, 0}), {-0.168, -0.185, 0}},
      {joints({0, 0, 0, 0, quarter}), {-0.353, 0, 0}},
  };
  for (const auto& row : golden) {
    EXPECT_LT((forward_kinematics(chain, row.q).p - row.p).cwiseAbs().maxCoeff(), kNineDigits) << row.q.transpose();
  }
  EXPECT_TRUE(forward_kinematics(chain, joints({0, 0, 0, quarter, 0})).R.isApprox(Matrix3::Identity(), 1e-12));
}

TEST(Kinematics, KeepsTheDistanceOfTheClosedForm) {
  const ArmModel arm = default_arm();
  std::mt19937 random(1);
  for (int k = 0; k < 100; ++k) {
    const JointVector q = test::random_within(arm.limits, random);
    const double squared = 0.168 * 0.168 + 0.185 * 0.185 + 2.0 * 0.168 * 0.185 * std::cos(q[3]);
    EXPECT_NEAR(forward_kinematics(arm.chain, q).p.squaredNorm(), squared, 1e-14);
  }
}

TEST(Kinematics, JacobianAgreesWithDifferencesOnChainsOfOneToEightJoints) {
  for (int n = 1; n <= kMaxJoints; ++n) {
    const SerialChain chain = test::general_chain(n, static_cast<unsigned>(n));
    std::mt19937 random(7);
    for (int k = 0; k < 20; ++k) {
      const JointVector q = test::random_between(JointVector::Constant(n, -3.0), JointVector::Constant(n, 3.0), random);
      const HandKinematics hand = hand_kinematics(chain, q);
      EXPECT_LT((hand.J - difference_jacobian(chain, q)).cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_LT(pose_error(hand.T_B_H, forward_kinematics(chain, q)).norm(), 1e-12);
    }
  }
}

TEST(Kinematics, ReachBoundsEveryPosture) {
  EXPECT_NEAR(reach_m(default_arm().chain), 0.353, 1e-12);
  const SerialChain chain = test::general_chain(6, 3);
  std::mt19937 random(2);
  for (int k = 0; k < 200; ++k) {
    const JointVector q = test::random_between(JointVector::Constant(6, -3.0), JointVector::Constant(6, 3.0), random);
    EXPECT_LE(forward_kinematics(chain, q).p.norm(), reach_m(chain));
  }
}

TEST(Kinematics, ManipulabilityIsTheLeastSingularValueOverTheReach) {
  std::mt19937 random(9);
  for (int k = 0; k < 300; ++k) {
    const SerialChain chain = k % 2 == 0 ? default_arm().chain : general_chain(3 + k % 6, static_cast<unsigned>(k));
    const Eigen::Index n = chain.joint_count;
    const JointVector q = random_between(JointVector::Constant(n, -2.0), JointVector::Constant(n, 2.0), random);
    const Jacobian J = hand_kinematics(chain, q).J;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(J.topRows<3>()));
    const double length = reach_m(chain) - chain.T_B_0.p.norm();
    const double expected = svd.singularValues()[2] / length;
    EXPECT_NEAR(position_manipulability(chain, q), expected, 1e-7);
    const double early = position_manipulability(chain, J, 0.05);
    EXPECT_LE(early, expected + 1e-9);
    EXPECT_GE(early, std::min(0.05, expected - 1e-7));
  }
}

TEST(Kinematics, ManipulabilityIsZeroAtTheStraightArmOnly) {
  const SerialChain chain = default_arm().chain;
  EXPECT_LT(position_manipulability(chain, joints({0.3, 0.2, 0.1, 0, 0.4})), 1e-8);
  EXPECT_GT(position_manipulability(chain, joints({0.3, -0.4, 0.5, 1.0, 0.2})), 0.1);
}

}  // namespace
}  // namespace armsight
