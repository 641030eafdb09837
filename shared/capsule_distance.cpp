#include "shared/capsule_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace armsight {
namespace {

constexpr double kPoint_m2 = 1e-18;  // shorter segments are points

double clamped(double t) { return std::clamp(t, 0.0, 1.0); }

/// Squared distance of a + t·u from the box, halved slope along t: Σ excess_i · u_i.
double slope_at(const Vector3& a, const Vector3& u, const Vector3& half, double t) {
  double slope = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double x = a[i] + t * u[i];
    slope += (x - std::clamp(x, -half[i], half[i])) * u[i];
  }
  return slope;
}

/// Keeps the first `count` entries in order.
void insert(std::array<double, 8>& sorted, std::size_t count, double t) {
  for (; count > 0 && sorted[count - 1] > t; --count) sorted[count] = sorted[count - 1];
  sorted[count] = t;
}

double box_distance_at(const Vector3& p, const Vector3& half) { return (p.cwiseAbs() - half).cwiseMax(0.0).norm(); }

}  // namespace

// The closest points of the lines, cut to the segments one after the other: what is cut off on one side moves the foot
// on the other. s runs from a to b, t from c to d.
double segment_distance_m(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 u = b - a, v = d - c, w = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  if (uu < kPoint_m2 && vv < kPoint_m2) return w.norm();
  if (uu < kPoint_m2) return (w - clamped(vw / vv) * v).norm();
  if (vv < kPoint_m2) return (w + clamped(-uw / uu) * u).norm();
  const double determinant = uu * vv - uv * uv;
  double s = determinant > 1e-12 * uu * vv ? clamped((uv * vw - vv * uw) / determinant) : 0.0;
  double t = (uv * s + vw) / vv;
  if (t < 0.0 || t > 1.0) {
    t = clamped(t);
    s = clamped((uv * t - uw) / uu);
  }
  return (w + s * u - t * v).norm();
}

// The squared distance is convex along the segment and quadratic between the places where it crosses a face's plane:
// the piece on which its slope changes sign holds the minimum, and there the slope is linear.
double segment_box_distance_m(const Vector3& a, const Vector3& b, const Vector3& half_size_m) {
  const Vector3 u = b - a;
  std::array<double, 8> cuts{0.0, 1.0};
  std::size_t count = 2;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (const double face : {-half_size_m[i], half_size_m[i]})
      if (const double t = (face - a[i]) / u[i]; t > 0.0 && t < 1.0) insert(cuts, count++, t);
  double t = 0.0, slope = slope_at(a, u, half_size_m, 0.0);
  for (std::size_t k = 1; k < count && slope < 0.0; ++k) {
    const double next = slope_at(a, u, half_size_m, cuts[k]);
    t = next <= 0.0 ? cuts[k] : cuts[k - 1] + (cuts[k] - cuts[k - 1]) * slope / (slope - next);
    slope = next;
  }
  return box_distance_at(a + t * u, half_size_m);
}

double distance_m(const Capsule& x, const Capsule& y) {
  return segment_distance_m(x.a_m, x.b_m, y.a_m, y.b_m) - x.radius_m - y.radius_m;
}

double distance_m(const Capsule& x, const HalfSpace& space) {
  return std::min(space.normal.dot(x.a_m), space.normal.dot(x.b_m)) - space.offset_m - x.radius_m;
}

double distance_m(const Capsule& x, const KeepOutBox& box) {
  const Pose T_X_B = box.T_B_X.inverse();
  return segment_box_distance_m(T_X_B * x.a_m, T_X_B * x.b_m, box.half_size_m) - x.radius_m;
}

}  // namespace armsight
