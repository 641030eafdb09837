// What the programs believe about the arm: its geometry, its limits, where the marker sits, and what was learnt.
// Any serial chain of 1 to 8 revolute joints: T_B_H(q) = T_B_0 · Π Rz(q_i) · T_i, where T_i is the fixed pose after
// joint i. A classic DH row is T_i = Rz(θ) Tz(d) Tx(a) Rx(α) (specification §4.1). Metres, radians, kilograms.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "shared/geometry.hpp"

namespace armsight {

inline constexpr int kMaxJoints = 8;

/// One value a joint, fixed capacity: no heap.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// 6 × joints, rows: linear then angular velocity.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// A row of classic (distal) DH parameters.
struct DhRow {
  double a_m = 0.0;
  double alpha_rad = 0.0;
  double d_m = 0.0;
  double theta_rad = 0.0;
};

/// T_i of a DH row with its θ offset: Rz(θ) Tz(d) Tx(a) Rx(α).
Pose dh_transform(const DhRow& row);

struct SerialChain {
  int joint_count = 0;
  Pose T_B_0;                             ///< base to the axis of joint 1
  std::array<Pose, kMaxJoints> T_after{};  ///< fixed pose after joint i; joint i turns about z
};

struct JointLimits {
  JointVector min_rad, max_rad;
  JointVector max_speed_rad_s, max_acceleration_rad_s2, max_jerk_rad_s3;
};

/// The arm as its description file says: constant while a program runs.
struct ArmModel {
  SerialChain chain;
  JointLimits limits;
  Pose T_H_M;  ///< marker seen from the hand

  int joint_count() const { return chain.joint_count; }
};

/// What Learn and Adapt change. q_real = q_reading + beta (4.3).
struct LearnedModel {
  std::uint64_t revision = 0;  ///< rises with every change; 0: nothing learnt
  Pose T_C_B;                  ///< base seen by the camera, as learnt (T_L_B of style.md with C = L)
  JointVector beta;            ///< joint offsets
};

}  // namespace armsight
