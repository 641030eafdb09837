// Where do the chains of host/chain_problem.hpp end, and how do the ends move with offsets, axes and time?
// Frames in the root 0; metres, radians, seconds.
#pragma once

#include <array>

#include "host/chain_problem.hpp"

namespace armsight::host {

struct JointFrame {
  Matrix3 R_0_before;      ///< frame in which the axis is described
  Vector3 axis, origin;    ///< of the true axis, in 0
  Matrix3 turn;            ///< R_0_before J_l(rx, ry, 0): what a change of the tilt turns, in 0
};

struct ChainMotion {
  Pose T_0_e;
  std::array<JointFrame, kMaxJoints> joints;
  int count = 0;           ///< 0 where nothing turns: root, given poses
};

/// Of a chain's end, at q + beta and the time offset; kRoot: the identity.
Pose end_pose(const ChainModel& model, int chain, const Observation& z);
ChainMotion end_motion(const ChainModel& model, int chain, const Observation& z);

/// Adds sign · (motion of a point p_0 that the chain's end carries), turned into C, to the columns of offsets, axes
/// and time.
void add_motion_columns(const ChainModel& model, int chain, const Observation& z, const ChainMotion& motion,
                        double sign, const Vector3& p_0, const Matrix3& R_C_0, const LookUnknowns& columns,
                        Eigen::MatrixXd& J);

}  // namespace armsight::host
