// Where in the picture things are: the ray of every pixel through the lens, and the pixels that a shape can cover.
#include <algorithm>
#include <cmath>

#include "tools/sim/ray_caster.hpp"

namespace armsight::sim {
namespace {

Matrix3 tube_outline(const Matrix3& R_S_C, const Vector3& o_S, double radius) {
  const Vector3 flat(o_S.x(), o_S.y(), 0.0);
  const double c = flat.squaredNorm() - radius * radius;
  const Matrix3 form = flat * flat.transpose() - c * Matrix3(Vector3(1.0, 1.0, 0.0).asDiagonal());
  return R_S_C.transpose() * form * R_S_C;
}

}  // namespace

RayCaster::RayCaster(const host::Intrinsics& intrinsics)
    : intrinsics_(intrinsics),
      rays_(intrinsics.height, intrinsics.width, CV_32FC2),
      nearest_(intrinsics.height, intrinsics.width, CV_32FC1),
      surface_(intrinsics.height, intrinsics.width, CV_16UC1, cv::Scalar(0)),
      spans_(static_cast<std::size_t>(intrinsics.height)) {
  for (int row = 0; row < rays_.rows; ++row) {
    for (int column = 0; column < rays_.cols; ++column) {
      const Eigen::Vector2d xy = host::undistort(intrinsics, cv::Point2d(column, row));
      rays_.at<cv::Vec2f>(row, column) = {static_cast<float>(xy.x()), static_cast<float>(xy.y())};
    }
  }
}

Vector3 RayCaster::ray(int row, int column) const {
  const cv::Vec2f& xy = rays_.at<cv::Vec2f>(row, column);
  return {static_cast<double>(xy[0]), static_cast<double>(xy[1]), 1.0};
}

/// Linear between pixel centres: the lens bends nothing visible inside one pixel.
Vector3 RayCaster::ray(double sub_column, double sub_row, int row, int column) const {
  const int c = std::clamp(column, 1, rays_.cols - 2), r = std::clamp(row, 1, rays_.rows - 2);
  const Vector3 across = 0.5 * (ray(r, c + 1) - ray(r, c - 1)), down = 0.5 * (ray(r + 1, c) - ray(r - 1, c));
  return ray(row, column) + sub_column * across + sub_row * down;
}

/// Pixels the shape can cover: around its box, cut at the near plane.
cv::Rect RayCaster::window_of(const Shape& shape) const {
  const cv::Rect picture(0, 0, rays_.cols, rays_.rows);
  const std::array<Vector3, 8> corners = bounds_C(shape);
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  const auto take = [&](const Vector3& p) {
    // Points far out of the picture need no lens, whose polynomial folds back out there.
    const double x = std::clamp(p.x() / p.z(), -1.5, 1.5), y = std::clamp(p.y() / p.z(), -1.2, 1.2);
    const cv::Point2d pixel(intrinsics_.fx * x + intrinsics_.cx, intrinsics_.fy * y + intrinsics_.cy);
    const Eigen::Vector2d bent = host::distort(intrinsics_, {x, y});
    const cv::Point2d seen(intrinsics_.fx * bent.x() + intrinsics_.cx, intrinsics_.fy * bent.y() + intrinsics_.cy);
    left = std::min({left, pixel.x, seen.x});
    right = std::max({right, pixel.x, seen.x});
    top = std::min({top, pixel.y, seen.y});
    bottom = std::max({bottom, pixel.y, seen.y});
  };
  bool is_before = false;
  for (std::size_t i = 0; i < 8; ++i) {
    if (corners[i].z() >= kNear) {
      is_before = true;
      take(corners[i]);
    }
    for (const std::size_t bit : {1U, 2U, 4U}) {  // edges of the box that pass the near plane
      const Vector3 &a = corners[i], &b = corners[i ^ bit];
      if (a.z() >= kNear && b.z() < kNear) take(a + (a.z() - kNear) / (a.z() - b.z()) * (b - a));
    }
  }
  if (!is_before) return {};
  const int x0 = static_cast<int>(std::floor(left)) - 2, y0 = static_cast<int>(std::floor(top)) - 2;
  return cv::Rect(x0, y0, static_cast<int>(right) - x0 + 4, static_cast<int>(bottom) - y0 + 4) & picture;
}

void RayCaster::place(std::vector<Shape> shapes) {
  posed_.clear();
  std::fill(spans_.begin(), spans_.end(), Span{rays_.cols, 0});
  for (Shape& shape : shapes) {
    const cv::Rect window = window_of(shape);
    if (window.empty() && !shape.print) continue;  // printed ones stay, so that reprint() can count them
    const Pose T_S_C = shape.T_C_S.inverse();
    const Matrix3 outline_C = tube_outline(T_S_C.R, T_S_C.p, shape.size.x());
    posed_.push_back({std::move(shape), T_S_C.R, T_S_C.p, window, outline_C});
    for (int row = window.y; row < window.br().y; ++row) {
      Span& span = spans_[static_cast<std::size_t>(row)];
      span = {std::min(span.begin, window.x), std::max(span.end, window.br().x)};
    }
  }
}

}  // namespace armsight::sim
