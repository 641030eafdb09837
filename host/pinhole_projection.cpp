#include "host/pinhole_projection.hpp"

namespace armsight::host {

std::optional<ProjectedPoint> project_with_jacobian(const Intrinsics& camera, const Vector3& p_C) {
  if (!(p_C.z() > 1e-6)) return std::nullopt;
  const double x = p_C.x() / p_C.z(), y = p_C.y() / p_C.z();
  const auto [k1, k2, p1, p2, k3] = camera.plumb_bob;
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3);  // ∂radial/∂r²
  const double xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;

  Eigen::Matrix2d distortion;  // ∂(xd, yd)/∂(x, y)
  distortion(0, 0) = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
  distortion(0, 1) = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
  distortion(1, 0) = distortion(0, 1);
  distortion(1, 1) = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  Eigen::Matrix<double, 2, 3> perspective;
  perspective << 1.0, 0.0, -x, 0.0, 1.0, -y;
  perspective /= p_C.z();

  ProjectedPoint point;
  point.pixel << camera.fx * xd + camera.cx, camera.fy * yd + camera.cy;
  point.J = Eigen::Vector2d(camera.fx, camera.fy).asDiagonal() * distortion * perspective;
  point.J_intrinsics.row(0) << xd, 0.0, 1.0, 0.0, camera.fx * x * r2, camera.fx * x * r2 * r2, camera.fx * 2.0 * x * y,
      camera.fx * (r2 + 2.0 * x * x), camera.fx * x * r2 * r2 * r2;
  point.J_intrinsics.row(1) << 0.0, yd, 0.0, 1.0, camera.fy * y * r2, camera.fy * y * r2 * r2,
      camera.fy * (r2 + 2.0 * y * y), camera.fy * 2.0 * x * y, camera.fy * y * r2 * r2 * r2;
  return point;
}

}  // namespace armsight::host
