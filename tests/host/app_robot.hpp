// The default robot (specification §4), by hand: tests of pure code need no robot file.
#pragma once

#include <cmath>
#include <numbers>

#include "shared/hand_eye.hpp"

namespace armsight::host {

inline ArmModel test_arm() {
  constexpr double kQuarter = std::numbers::pi / 2;
  const DhRow rows[] = {{0, kQuarter, 0, 0},
                        {0, -kQuarter, 0, kQuarter},
                        {0, -kQuarter, 0.168, -kQuarter},
                        {0, kQuarter, 0, 0},
                        {0, -kQuarter, 0.185, 0}};
  ArmModel arm;
  arm.chain.joint_count = 5;
  for (std::size_t i = 0; i < 5; ++i) arm.chain.T_after[i] = dh_transform(rows[i]);
  arm.limits.min_rad.resize(5);
  arm.limits.max_rad.resize(5);
  arm.limits.min_rad << -1.57, -1.57, -1.57, 0, -1.57;
  arm.limits.max_rad << 1.57, 0.81, 1.57, 2.355, 1.57;
  arm.T_H_M.R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  arm.T_H_M.p = Vector3(0.020, -0.030, 0);
  return arm;
}

inline Pose test_T_C_B() {
  const double c = std::cos(40 * kDegree), s = std::sin(40 * kDegree);
  Pose T;
  T.R << 0, 0, 1, -c, s, 0, -s, -c, 0;
  T.p = Vector3(0.184, 0.112 * c + 0.045 * s, 0.112 * s - 0.045 * c);
  return T;
}

/// P of the filter's wide prior: 30 mm, 4°, 3° a joint, joint 1 held by 0.5°.
inline StateMatrix wide_prior(int joints) {
  StateMatrix P = StateMatrix::Zero(6 + joints, 6 + joints);
  P.diagonal().head<3>().setConstant(0.03 * 0.03);
  P.diagonal().segment<3>(3).setConstant(0.07 * 0.07);
  P.diagonal().tail(joints).setConstant(0.052 * 0.052);
  P(6, 6) = 0.0087 * 0.0087;
  return P;
}

}  // namespace armsight::host
