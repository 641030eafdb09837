// Least squares under bounds: min ½ xᵀNx − gᵀx, lower ≤ x ≤ upper, for one variable a joint. Exact active set; the
// problems are so small that nothing faster is needed (controller.md §6.4). No heap, no throw.
#pragma once

#include "shared/arm_model.hpp"

namespace armsight {

using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;

/// N symmetric positive definite, lower ≤ upper.
JointVector solve_box_qp(const JointMatrix& N, const JointVector& g, const JointVector& lower, const JointVector& upper);

}  // namespace armsight
