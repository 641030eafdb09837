// Where does a point in front of the camera fall in the picture, and how does it move there? The camera of
// host/intrinsics.hpp with its derivative, for the reprojection cost; specification (2.1)–(2.2).
#pragma once

#include <optional>

#include "host/intrinsics.hpp"

namespace armsight::host {

struct ProjectedPoint {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> J;  ///< ∂pixel/∂p_C
  Eigen::Matrix<double, 2, 9> J_intrinsics;  ///< ∂pixel/∂(fx, fy, cx, cy, k1, k2, p1, p2, k3)
};
/// nullopt for a point that is not in front of the camera.
std::optional<ProjectedPoint> project_with_jacobian(const Intrinsics& camera, const Vector3& p_C);

}  // namespace armsight::host
