#include "tools/sim/printed_marker.hpp"

#include <Eigen/LU>

namespace armsight::sim {
namespace {

std::array<Vector3, 4> corners_M(double side_m) {
  const double h = 0.5 * side_m;
  return {Vector3(-h, h, 0), Vector3(h, h, 0), Vector3(h, -h, 0), Vector3(-h, -h, 0)};
}

/// Homography that takes four plane points to four others.
Matrix3 homography(const std::array<Eigen::Vector2d, 4>& from, const std::array<Eigen::Vector2d, 4>& to) {
  Eigen::Matrix<double, 8, 8> A;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d& s = from[static_cast<std::size_t>(i)];
    const Eigen::Vector2d& d = to[static_cast<std::size_t>(i)];
    A.row(2 * i) << s.x(), s.y(), 1, 0, 0, 0, -d.x() * s.x(), -d.x() * s.y();
    A.row(2 * i + 1) << 0, 0, 0, s.x(), s.y(), 1, -d.y() * s.x(), -d.y() * s.y();
    b.segment<2>(2 * i) = d;
  }
  const Eigen::Matrix<double, 8, 1> h = A.fullPivLu().solve(b);
  Matrix3 H;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0;
  return H;
}

}  // namespace

std::optional<host::Corners> project_corners(const Pose& T_C_M, double side_m, const host::Intrinsics& intrinsics) {
  host::Corners corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3 p = T_C_M * corners_M(side_m)[i];
    if (p.z() < 0.02) return std::nullopt;
    corners[i] = host::project(intrinsics, p);
  }
  return corners;
}

std::optional<MarkerPrint> MarkerPrint::make(const host::MarkerPattern& pattern, double side_m, const Pose& T_C_M,
                                             const host::Intrinsics& intrinsics, const CornerShift& shift_px) {
  const auto projected = project_corners(T_C_M, side_m, intrinsics);
  if (!projected) return std::nullopt;
  const double n = pattern.modules;
  const std::array<Eigen::Vector2d, 4> modules = {Eigen::Vector2d(0, 0), {n, 0}, {n, n}, {0, n}};
  std::array<Eigen::Vector2d, 4> rays;
  for (std::size_t i = 0; i < 4; ++i) rays[i] = host::undistort(intrinsics, (*projected)[i] + shift_px[i]);
  MarkerPrint print;
  print.pattern_ = pattern;
  print.modules_from_ray_ = homography(rays, modules);
  return print;
}

}  // namespace armsight::sim
