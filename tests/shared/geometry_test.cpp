// Axioms of poses and rotations, with the nasty places: 0, tiny angles, π.
#include "shared/geometry.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/shared/default_arm.hpp"

namespace armsight {
namespace {

constexpr double kPi = std::numbers::pi;
const double kNastyAngles[] = {0.0,  1e-300, 1e-12, 1e-9,       1e-8,       1e-6,        1e-5,      1e-4,
                               1e-3, 0.5,    2.0,   kPi - 1e-3, kPi - 1e-6, kPi - 1e-9, kPi - 1e-12};

Vector3 random_direction(std::mt19937& random) { return test::random_vector(1.0, random).normalized(); }

TEST(Geometry, LogUndoesExpFromZeroToPi) {
  std::mt19937 random(1);
  for (const double angle : kNastyAngles) {
    for (int k = 0; k < 50; ++k) {
      const Vector3 phi = angle * random_direction(random);
      EXPECT_LT((so3_log(so3_exp(phi)) - phi).norm(), 1e-11) << angle;
    }
  }
}

TEST(Geometry, LogAtExactlyPiGivesOneOfTheTwoAxes) {
  for (const Vector3& axis : {Vector3::UnitX().eval(), Vector3::UnitY().eval(), Vector3(1, -2, 0.5).normalized()}) {
    const Matrix3 R = 2.0 * axis * axis.transpose() - Matrix3::Identity();
    const Vector3 phi = so3_log(R);
    EXPECT_NEAR(phi.norm(), kPi, 1e-12);
    EXPECT_NEAR(std::abs(phi.normalized().dot(axis)), 1.0, 1e-12);
  }
}

TEST(Geometry, ExpIsARotationAndAHomomorphismAlongAnAxis) {
  std::mt19937 random(2);
  for (const double angle : kNastyAngles) {
    const Vector3 axis = random_direction(random);
    const Matrix3 R = so3_exp(angle * axis);
    EXPECT_TRUE(is_rotation(R, 1e-14));
    EXPECT_TRUE((R * R).isApprox(so3_exp(2.0 * angle * axis), 1e-14));
  }
}

TEST(Geometry, LeftJacobianAgreesWithDifferences) {
  constexpr double kStep = 1e-6;
  std::mt19937 random(3);
  for (const double angle : {0.0, 1e-6, 0.99e-4, 1.01e-4, 1e-2, 1.0, 3.0}) {
    const Vector3 phi = angle * random_direction(random);
    for (int i = 0; i < 3; ++i) {
      const Vector3 d = kStep * Vector3::Unit(i);
      const Vector3 column = so3_log(so3_exp(phi + d) * so3_exp(phi - d).transpose()) / (2.0 * kStep);
      EXPECT_LT((column - so3_left_jacobian(phi).col(i)).norm(), 1e-8) << angle;
    }
  }
}

TEST(Geometry, PoseTimesInverseIsIdentity) {
  std::mt19937 random(4);
  for (int k = 0; k < 100; ++k) {
    const Pose T{so3_exp(test::random_vector(2.0, random)), test::random_vector(1.0, random)};
    const Pose I = T * T.inverse();
    EXPECT_TRUE(I.R.isApprox(Matrix3::Identity(), 1e-13));
    EXPECT_LT(I.p.norm(), 1e-13);
    const Vector3 x = test::random_vector(1.0, random);
    EXPECT_LT((T.inverse() * (T * x) - x).norm(), 1e-13);
  }
}

TEST(Geometry, SkewIsTheCrossProductAndVeeItsInverse) {
  const Vector3 v(0.3, -0.2, 0.9), x(1.0, 2.0, -0.5);
  EXPECT_LT((skew(v) * x - v.cross(x)).norm(), 1e-15);
  EXPECT_EQ(vee(skew(v)), v);
}

TEST(Geometry, SineErrorIsSineOfTheAngle) {
  const Vector3 phi = 0.7 * Vector3(1, 2, -2) / 3.0;
  EXPECT_LT((orientation_error_sine(so3_exp(phi), Matrix3::Identity()) - phi / 0.7 * std::sin(0.7)).norm(), 1e-14);
}

TEST(Geometry, PoseErrorOfAPoseWithItselfIsZero) {
  const Pose T{so3_exp(Vector3(1, 2, -0.5)), Vector3(0.1, 0.2, 0.3)};
  EXPECT_LT(pose_error(T, T).norm(), 1e-15);
}

TEST(Geometry, NearestRotationRepairsARoughMatrix) {
  const Matrix3 R = so3_exp(Vector3(0.4, -0.9, 0.2));
  EXPECT_LT(rotation_angle(nearest_rotation(1.7 * R), R), 1e-14);
  EXPECT_TRUE(is_rotation(nearest_rotation(R + 0.05 * Matrix3::Ones()), 1e-12));
}

TEST(Geometry, RefusesWhatIsNoRotation) {
  EXPECT_FALSE(is_rotation(-Matrix3::Identity()));
  EXPECT_FALSE(is_rotation(1.001 * Matrix3::Identity()));
  EXPECT_FALSE(is_rotation(Matrix3::Constant(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_FALSE(is_finite(Pose{Matrix3::Identity(), Vector3(0, 0, std::numeric_limits<double>::infinity())}));
}

}  // namespace
}  // namespace armsight
