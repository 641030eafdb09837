#include "host/edge_refine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace armsight::host {
namespace {

using Point = Eigen::Vector2d;

constexpr double kStep_px = 0.5;          // along a profile
constexpr double kMaxCornerMove_px = 3.0;
// In a wide black border OpenCV's adaptive threshold sees a second contour, up to half its window of 23 px inside the
// true one, and keeps it where the outer one touches something else.
constexpr std::array<double, 6> kOutwards_px{0.0, 3.0, 5.0, 7.0, 9.0, 11.0};
constexpr double kMinContrast = 12.0;     // gray levels between border and margin

Point to_point(const cv::Point2d& p) { return {p.x, p.y}; }

/// Bilinear; integer coordinates are pixel centres. The caller keeps inside the picture.
double sample(const cv::Mat& gray, const Point& p) {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
  const double u = p.x() - x, v = p.y() - y;
  const unsigned char* row = gray.ptr(y);
  const unsigned char* below = gray.ptr(y + 1);
  return (1.0 - v) * ((1.0 - u) * row[x] + u * row[x + 1]) + v * ((1.0 - u) * below[x] + u * below[x + 1]);
}

bool is_inside(const cv::Mat& gray, const Point& p) {
  return p.x() >= 0.0 && p.y() >= 0.0 && p.x() < gray.cols - 1.001 && p.y() < gray.rows - 1.001;
}

/// Where the gray value along base + t·normal, |t| ≤ reach, passes the middle between the border's black (t < 0) and
/// the margin's white; the crossing of the middle stays put under any symmetric blur.
std::optional<double> edge_position(const cv::Mat& gray, const Point& base, const Point& normal, double reach) {
  const int n = static_cast<int>(std::floor(reach / kStep_px));
  if (!is_inside(gray, base + reach * normal) || !is_inside(gray, base - reach * normal)) return std::nullopt;
  std::array<double, 64> profile{};
  for (int i = -n; i <= n; ++i) profile[static_cast<std::size_t>(i + n)] = sample(gray, base + i * kStep_px * normal);
  const std::size_t size = static_cast<std::size_t>(2 * n + 1), quarter = std::max<std::size_t>(size / 5, 1);
  double black = 0.0, white = 0.0;
  for (std::size_t i = 0; i < quarter; ++i) {
    black += profile[i] / static_cast<double>(quarter);
    white += profile[size - 1 - i] / static_cast<double>(quarter);
  }
  if (white - black < kMinContrast) return std::nullopt;
  const double middle = 0.5 * (black + white);
  std::optional<double> position;
  for (std::size_t i = 0; i + 1 < size; ++i) {
    if (profile[i] > middle || profile[i + 1] <= middle) continue;
    const double t = (static_cast<double>(i) + (middle - profile[i]) / (profile[i + 1] - profile[i])) * kStep_px -
                     n * kStep_px;
    if (!position || std::abs(t) < std::abs(*position)) position = t;
  }
  return position;
}

struct Line {
  Point normal;
  double offset = 0.0;  ///< normal · x = offset
  double rms = 0.0;
};

/// Total least squares, Tukey weights at 4.5 times the median distance: a fleck or a shadow's edge is left out.
std::optional<Line> fit_line(const std::vector<Point>& points) {
  std::vector<double> weights(points.size(), 1.0);
  Line line;
  for (int round = 0; round < 6; ++round) {
    double sum = 0.0;
    Point mean = Point::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      sum += weights[i];
      mean += weights[i] * points[i];
    }
    if (sum < 4.0) return std::nullopt;
    mean /= sum;
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      scatter += weights[i] * (points[i] - mean) * (points[i] - mean).transpose();
    }
    const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
    line.normal = {-std::sin(angle), std::cos(angle)};
    line.offset = line.normal.dot(mean);
    std::vector<double> distances(points.size());
    double squares = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      distances[i] = std::abs(line.normal.dot(points[i]) - line.offset);
      squares += weights[i] * distances[i] * distances[i];
    }
    line.rms = std::sqrt(squares / sum);
    std::vector<double> sorted = distances;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double cut = std::max(4.5 * sorted[sorted.size() / 2], 1e-6);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double r = distances[i] / cut;
      weights[i] = r < 1.0 ? (1.0 - r * r) * (1.0 - r * r) : 0.0;
    }
  }
  return line;
}

std::optional<Point> meet(const Line& a, const Line& b) {
  Eigen::Matrix2d N;
  N << a.normal.transpose(), b.normal.transpose();
  const double det = N.determinant();
  if (std::abs(det) < 0.05) return std::nullopt;
  return N.inverse() * Point(a.offset, b.offset);
}

/// The line of the edge from a to b, clockwise, in undistorted pixels (fx·x, fy·y).
std::optional<Line> edge_line(const cv::Mat& gray, const Intrinsics& k, const Point& a, const Point& b, double reach) {
  const Point along = b - a;
  const double length = along.norm();
  const Point normal = Point(along.y(), -along.x()) / length;  // outwards for a clockwise outline, y down
  const int samples = std::clamp(static_cast<int>(length), 12, 160);
  std::vector<Point> points;
  for (int i = 0; i < samples; ++i) {
    const double s = 0.07 + 0.86 * (i + 0.5) / samples;        // not at the corners: the neighbour edge would count
    const Point base = a + s * along;
    if (const auto t = edge_position(gray, base, normal, reach)) {
      const Point pixel = base + *t * normal;
      const Point xy = undistort(k, {pixel.x(), pixel.y()});
      points.emplace_back(k.fx * xy.x(), k.fy * xy.y());
    }
  }
  if (points.size() < static_cast<std::size_t>(samples / 3 + 4)) return std::nullopt;
  return fit_line(points);
}

std::optional<RefinedCorners> refine_once(const cv::Mat& gray, const Intrinsics& k, const Corners& corners,
                                          int modules) {
  std::array<Line, 4> lines;
  double squares = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point a = to_point(corners[i]), b = to_point(corners[(i + 1) % 4]);
    const Point c = to_point(corners[(i + 2) % 4]), d = to_point(corners[(i + 3) % 4]);
    const Point direction = (b - a).normalized();
    const auto width = [&](const Point& p) {
      return std::abs(direction.x() * (p - a).y() - direction.y() * (p - a).x());
    };
    const double module = 0.5 * (width(c) + width(d)) / modules;  // across this edge, foreshortened
    const auto line = edge_line(gray, k, a, b, std::clamp(0.75 * module, 1.6, 12.0));
    if (!line) return std::nullopt;
    lines[i] = *line;
    squares += line->rms * line->rms / 4.0;
  }
  RefinedCorners refined;
  refined.edge_rms_px = std::sqrt(squares);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = meet(lines[(i + 3) % 4], lines[i]);
    if (!corner) return std::nullopt;
    refined.corners_px[i] = to_pixel(k, {corner->x() / k.fx, corner->y() / k.fy});
  }
  return refined;
}

/// From an outline good to ±2 px; the second round with profiles centred on the edge.
std::optional<RefinedCorners> refine_near(const cv::Mat& gray, const Intrinsics& k, const Corners& start, int modules) {
  Corners at = start;
  std::optional<RefinedCorners> refined;
  for (int round = 0; round < 2; ++round) {
    refined = refine_once(gray, k, at, modules);
    if (!refined) return std::nullopt;
    for (std::size_t i = 0; i < 4; ++i) {
      const cv::Point2d move = refined->corners_px[i] - start[i];
      if (!(std::hypot(move.x, move.y) < kMaxCornerMove_px)) return std::nullopt;
    }
    at = refined->corners_px;
  }
  return refined;
}

/// Every edge moved outwards by about `out_px`.
Corners grown(const Corners& corners, double out_px) {
  const cv::Point2d centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  double side = 0.0;
  for (std::size_t i = 0; i < 4; ++i) side += 0.25 * cv::norm(corners[(i + 1) % 4] - corners[i]);
  Corners out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = centre + (1.0 + 2.0 * out_px / side) * (corners[i] - centre);
  return out;
}

}  // namespace

std::optional<RefinedCorners> refine_corners(const cv::Mat& gray, const Intrinsics& intrinsics,
                                             const Corners& corners_px, int modules) {
  for (const double out_px : kOutwards_px) {
    if (const auto refined = refine_near(gray, intrinsics, grown(corners_px, out_px), modules)) return refined;
  }
  return std::nullopt;
}

}  // namespace armsight::host
