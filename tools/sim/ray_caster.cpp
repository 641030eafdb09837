#include "tools/sim/ray_caster.hpp"

#include <algorithm>
#include <cmath>

#include "tools/sim/printed_marker.hpp"

namespace armsight::sim {
namespace {

constexpr double kNear = 0.03;        // m, what is nearer is not drawn
constexpr int kPrintSamples = 64;     // a pixel with a print's edge: 1/64 px steps even for edges along the rows
constexpr int kEdgeSamples = 8;

/// Surfaces of one shape: 8 plain parts and two tones of its print.
constexpr int kSurfaces = 16;
constexpr int kBlack = 8, kWhite = 9;

/// Sample i of n in the pixel, each coordinate taking n distinct values: Hammersley's points, about the centre.
double second_coordinate(int i, int n) {
  double value = 0.0, step = 0.5;
  for (int bits = i; bits > 0; bits >>= 1, step *= 0.5) value += (bits & 1) != 0 ? step : 0.0;
  return value + 0.5 / n - 0.5;
}
double first_coordinate(int i, int n) { return (i + 0.5) / n - 0.5; }

}  // namespace

struct RayCaster::Posed {
  const Shape* shape;
  Matrix3 R_S_C;
  Vector3 o_S;        ///< the camera in S
  cv::Rect window;
  Matrix3 outline_C;  ///< dᵀQd < 0: the ray passes the endless tube about z_S (b² − ac of its quadratic equation)

  bool may_meet(const Vector3& d_C) const { return shape->form == Form::kBox || d_C.dot(outline_C * d_C) >= 0.0; }
  double distance(const Vector3& d_C) const { return may_meet(d_C) ? meet(*shape, o_S, R_S_C * d_C) : -1.0; }
  Vector3 point(const Vector3& d_C, double t) const { return o_S + t * (R_S_C * d_C); }
};

namespace {

Matrix3 tube_outline(const Matrix3& R_S_C, const Vector3& o_S, double radius) {
  const Vector3 flat(o_S.x(), o_S.y(), 0.0);
  const double c = flat.squaredNorm() - radius * radius;
  const Matrix3 form = flat * flat.transpose() - c * Matrix3(Vector3(1.0, 1.0, 0.0).asDiagonal());
  return R_S_C.transpose() * form * R_S_C;
}

/// Print under the ray, if the point lies on the printed face.
std::optional<bool> module_at(const Shape& shape, int part, const Vector3& d_C) {
  if (!shape.print || part != kTop) return std::nullopt;
  return shape.print->is_white(d_C.x(), d_C.y());
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

void RayCaster::draw_room(const Stage& stage, Canvas& canvas) const {
  canvas.grey.create(rays_.size(), CV_32FC1);
  canvas.depth.create(rays_.size(), CV_32FC1);
  canvas.depth.setTo(1e9);
  for (int row = 0; row < rays_.rows; ++row) {
    for (int column = 0; column < rays_.cols; ++column) {
      canvas.grey.at<float>(row, column) = static_cast<float>(shade_room(stage, ray(row, column)));
    }
  }
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

void RayCaster::find_nearest(const std::vector<Posed>& posed, const Canvas& canvas) {
  for (std::size_t row = 0; row < spans_.size(); ++row) {
    const Span& span = spans_[row];
    if (span.begin >= span.end) continue;
    const int r = static_cast<int>(row);
    std::copy_n(canvas.depth.ptr<float>(r) + span.begin, span.end - span.begin, nearest_.ptr<float>(r) + span.begin);
    std::fill_n(surface_.ptr<std::uint16_t>(r) + span.begin, span.end - span.begin, std::uint16_t{0});
  }
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const Posed& p = posed[i];
    for (int row = p.window.y; row < p.window.br().y; ++row) {
      float* nearest = nearest_.ptr<float>(row);
      std::uint16_t* surface = surface_.ptr<std::uint16_t>(row);
      for (int column = p.window.x; column < p.window.br().x; ++column) {
        const Vector3 d = ray(row, column);
        const double t = p.distance(d);
        if (!(t > kNear) || t >= static_cast<double>(nearest[column])) continue;
        nearest[column] = static_cast<float>(t);
        const int part = part_of(*p.shape, p.point(d, t));
        const auto module = module_at(*p.shape, part, d);
        const int tone = module ? (*module ? kWhite : kBlack) : part;
        surface[column] = static_cast<std::uint16_t>(1 + static_cast<int>(i) * kSurfaces + tone);
      }
    }
  }
}

/// What can be met inside the pixel: the surfaces nearest at its centre and at its eight neighbours'.
RayCaster::Meeting RayCaster::meeting_at(int row, int column) const {
  Meeting meeting;
  const std::uint16_t own = surface_.at<std::uint16_t>(row, column);
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, surface_.rows - 1); ++r) {
    const Span& span = spans_[static_cast<std::size_t>(r)];
    const std::uint16_t* line = surface_.ptr<std::uint16_t>(r);
    for (int c = column - 1; c <= column + 1; ++c) {
      const std::uint16_t other = c >= span.begin && c < span.end ? line[c] : std::uint16_t{0};
      meeting.is_edge = meeting.is_edge || other != own;
      if (other == 0) continue;
      meeting.has_print = meeting.has_print || (other - 1) % kSurfaces >= kBlack;
      const int shape = (other - 1) / kSurfaces;
      const auto end = meeting.shapes.begin() + meeting.count;
      if (std::find(meeting.shapes.begin(), end, shape) == end) meeting.shapes[static_cast<std::size_t>(meeting.count++)] = shape;
    }
  }
  return meeting;
}

double RayCaster::mean_over_pixel(const Stage& stage, const std::vector<Posed>& posed, const Canvas& canvas, int row,
                                  int column, const Meeting& meeting) const {
  const int samples = meeting.has_print ? kPrintSamples : kEdgeSamples;
  double sum = 0.0;
  for (int i = 0; i < samples; ++i) {
    const Vector3 d = ray(first_coordinate(i, samples), second_coordinate(i, samples), row, column);
    double nearest = static_cast<double>(canvas.depth.at<float>(row, column));
    const Posed* hit = nullptr;
    for (int c = 0; c < meeting.count; ++c) {
      const Posed& candidate = posed[static_cast<std::size_t>(meeting.shapes[static_cast<std::size_t>(c)])];
      const double t = candidate.distance(d);
      if (t > kNear && t < nearest) {
        nearest = t;
        hit = &candidate;
      }
    }
    if (hit == nullptr) {
      sum += static_cast<double>(canvas.grey.at<float>(row, column));
      continue;
    }
    const Vector3 p_S = hit->point(d, nearest);
    const int part = part_of(*hit->shape, p_S);
    sum += shade(stage, *hit->shape, nearest * d, p_S, part, module_at(*hit->shape, part, d));
  }
  return sum / samples;
}

void RayCaster::draw(const Stage& stage, const std::vector<Shape>& shapes, Canvas& canvas) {
  std::vector<Posed> posed;
  std::fill(spans_.begin(), spans_.end(), Span{rays_.cols, 0});
  for (const Shape& shape : shapes) {
    const cv::Rect window = window_of(shape);
    if (window.empty()) continue;
    const Pose T_S_C = shape.T_C_S.inverse();
    posed.push_back({&shape, T_S_C.R, T_S_C.p, window, tube_outline(T_S_C.R, T_S_C.p, shape.size.x())});
    for (int row = window.y; row < window.br().y; ++row) {
      Span& span = spans_[static_cast<std::size_t>(row)];
      span = {std::min(span.begin, window.x), std::max(span.end, window.br().x)};
    }
  }
  find_nearest(posed, canvas);
  for (int row = 0; row < rays_.rows; ++row) {
    const Span& span = spans_[static_cast<std::size_t>(row)];
    float* grey = canvas.grey.ptr<float>(row);
    const std::uint16_t* surface = surface_.ptr<std::uint16_t>(row);
    for (int column = span.begin; column < span.end; ++column) {
      if (const Meeting meeting = meeting_at(row, column); meeting.is_edge) {
        grey[column] = static_cast<float>(mean_over_pixel(stage, posed, canvas, row, column, meeting));
      } else if (surface[column] != 0) {
        const Posed& p = posed[static_cast<std::size_t>((surface[column] - 1) / kSurfaces)];
        const Vector3 d = ray(row, column);
        const double t = static_cast<double>(nearest_.at<float>(row, column));
        const Vector3 p_S = p.point(d, t);
        const int tone = (surface[column] - 1) % kSurfaces, part = tone >= kBlack ? kTop : tone;
        const std::optional<bool> module = tone >= kBlack ? std::optional<bool>(tone == kWhite) : std::nullopt;
        grey[column] = static_cast<float>(shade(stage, *p.shape, t * d, p_S, part, module));
      }
    }
  }
  // Depth last: the edge pass has to see the canvas as it was.
  for (int row = 0; row < rays_.rows; ++row) {
    const Span& span = spans_[static_cast<std::size_t>(row)];
    if (span.begin < span.end) {
      std::copy_n(nearest_.ptr<float>(row) + span.begin, span.end - span.begin, canvas.depth.ptr<float>(row) + span.begin);
    }
  }
}

}  // namespace armsight::sim
