// The default robot of specification §4, written down once more by hand so that the tests do not trust the robot file.
#pragma once

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <random>

#include "shared/arm_model.hpp"

namespace armsight::test {

inline JointVector joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q[i++] = value;
  return q;
}

/// Table 7.1 (a, α, d, θ) and the limits of §4.4.
inline ArmModel default_arm() {
  constexpr double kQuarter = std::numbers::pi / 2.0;
  ArmModel arm;
  arm.chain.joint_count = 5;
  arm.chain.T_after[0] = dh_transform({0.0, kQuarter, 0.0, 0.0});
  arm.chain.T_after[1] = dh_transform({0.0, -kQuarter, 0.0, kQuarter});
  arm.chain.T_after[2] = dh_transform({0.0, -kQuarter, 0.168, -kQuarter});
  arm.chain.T_after[3] = dh_transform({0.0, kQuarter, 0.0, 0.0});
  arm.chain.T_after[4] = dh_transform({0.0, -kQuarter, 0.185, 0.0});
  arm.limits.min_rad = joints({-1.57, -1.57, -1.57, 0.0, -1.57});
  arm.limits.max_rad = joints({1.57, 0.81, 1.57, 2.355, 1.57});
  arm.limits.max_speed_rad_s = JointVector::Constant(5, 0.5);
  arm.limits.max_acceleration_rad_s2 = JointVector::Constant(5, 2.0);
  arm.limits.max_jerk_rad_s3 = JointVector::Constant(5, 20.0);
  arm.T_H_M.R << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // x_M = −z_H, y_M = y_H, z_M = x_H (§4.6)
  arm.T_H_M.p << 0.020, -0.030, 0.0;
  return arm;
}

/// §4.6: the camera's nominal mount.
inline Pose default_T_C_B() {
  const double angle = 40.0 * kDegree;
  const double c = std::cos(angle), s = std::sin(angle);
  Pose T;
  T.R << 0, 0, 1, -c, s, 0, -s, -c, 0;
  T.p << 0.184, 0.112 * c + 0.045 * s, 0.112 * s - 0.045 * c;
  return T;
}

/// A chain of general shape, with offsets in every place, for what must not depend on the default arm.
inline SerialChain general_chain(int joint_count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  SerialChain chain;
  chain.joint_count = joint_count;
  const auto pose = [&](double size) {
    Pose T;
    T.R = so3_exp(Vector3(u(random), u(random), u(random)));
    T.p = size * Vector3(u(random), u(random), u(random));
    return T;
  };
  chain.T_B_0 = pose(0.1);
  for (int i = 0; i < joint_count; ++i) {
    const DhRow row{0.1 * u(random), i % 2 == 0 ? 1.5 : -1.5, 0.1 + 0.1 * u(random), u(random)};
    chain.T_after[static_cast<std::size_t>(i)] = dh_transform(row) * pose(0.02);
  }
  return chain;
}

inline JointVector random_between(const JointVector& min, const JointVector& max, std::mt19937& random) {
  std::uniform_real_distribution<double> u(0.0, 1.0);
  JointVector q(min.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = min[i] + (max[i] - min[i]) * u(random);
  return q;
}

inline JointVector random_within(const JointLimits& limits, std::mt19937& random) {
  return random_between(limits.min_rad, limits.max_rad, random);
}

inline Vector3 random_vector(double sigma, std::mt19937& random) {
  std::normal_distribution<double> n(0.0, sigma);
  const double x = n(random), y = n(random), z = n(random);
  return {x, y, z};
}

}  // namespace armsight::test
