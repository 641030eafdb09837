#include "tools/sim/shapes.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace armsight::sim {
namespace {

constexpr double kMissed = -1.0;

double meet_box(const Vector3& half, const Vector3& o, const Vector3& d) {
  double near = -std::numeric_limits<double>::infinity(), far = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double inverse = 1.0 / (std::abs(d[i]) > 1e-15 ? d[i] : 1e-15);
    const double a = (-half[i] - o[i]) * inverse, b = (half[i] - o[i]) * inverse;
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far && near > 0.0 ? near : kMissed;
}

double meet_sphere(double radius, const Vector3& o, const Vector3& d) {
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - radius * radius;
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return kMissed;
  const double t = (-b - std::sqrt(discriminant)) / a;
  return t > 0.0 ? t : kMissed;
}

/// Entry into the endless cylinder about z; nullopt: missed or started inside.
std::optional<double> enter_tube(double radius, const Vector3& o, const Vector3& d) {
  const double a = d.x() * d.x() + d.y() * d.y(), b = o.x() * d.x() + o.y() * d.y();
  const double c = o.x() * o.x() + o.y() * o.y() - radius * radius;
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0 || a < 1e-18) return std::nullopt;
  return (-b - std::sqrt(discriminant)) / a;
}

double meet_capsule(const Vector3& size, const Vector3& o, const Vector3& d) {
  const auto t = enter_tube(size.x(), o, d);
  if (!t) return kMissed;
  const double z = o.z() + *t * d.z();
  if (std::abs(z) <= size.z()) return *t > 0.0 ? *t : kMissed;
  return meet_sphere(size.x(), o - Vector3(0.0, 0.0, std::copysign(size.z(), z)), d);
}

double meet_cylinder(const Vector3& size, const Vector3& o, const Vector3& d) {
  const auto t = enter_tube(size.x(), o, d);
  if (!t) return kMissed;
  const double z = o.z() + *t * d.z();
  if (std::abs(z) <= size.z()) return *t > 0.0 ? *t : kMissed;
  if (std::abs(d.z()) < 1e-15) return kMissed;
  const double cap = (std::copysign(size.z(), z) - o.z()) / d.z();
  const double x = o.x() + cap * d.x(), y = o.y() + cap * d.y();
  return cap > 0.0 && cap >= *t && x * x + y * y <= size.x() * size.x() ? cap : kMissed;
}

}  // namespace

double meet(const Shape& shape, const Vector3& o_S, const Vector3& d_S) {
  switch (shape.form) {
    case Form::kBox: return meet_box(shape.size, o_S, d_S);
    case Form::kCapsule: return meet_capsule(shape.size, o_S, d_S);
    case Form::kCylinder: return meet_cylinder(shape.size, o_S, d_S);
  }
  return kMissed;
}

int part_of(const Shape& shape, const Vector3& p_S) {
  if (shape.form == Form::kCapsule) return 0;
  if (shape.form == Form::kCylinder) {
    if (std::abs(p_S.z()) < shape.size.z() * (1.0 - 1e-9)) return 0;
    return p_S.z() > 0.0 ? kTop : kTop + 1;
  }
  int axis = 0;
  p_S.cwiseAbs().cwiseQuotient(shape.size).maxCoeff(&axis);
  return 2 * axis + (p_S[axis] > 0.0 ? 0 : 1);
}

Vector3 normal_S(const Shape& shape, const Vector3& p_S, int part) {
  if (shape.form == Form::kBox || part >= kTop) return Vector3::Unit(part / 2) * (part % 2 == 0 ? 1.0 : -1.0);
  const double beyond = p_S.z() - std::clamp(p_S.z(), -shape.size.z(), shape.size.z());
  return Vector3(p_S.x(), p_S.y(), beyond).normalized();
}

std::array<Vector3, 8> bounds_C(const Shape& shape) {
  Vector3 half = shape.size;
  if (shape.form == Form::kCapsule) half.z() += shape.size.x();
  std::array<Vector3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vector3 sign(i & 1U ? 1.0 : -1.0, i & 2U ? 1.0 : -1.0, i & 4U ? 1.0 : -1.0);
    corners[i] = shape.T_C_S * Vector3(half.cwiseProduct(sign));
  }
  return corners;
}

Shape box(Material material, const Pose& T_C_S, const Vector3& half) {
  return {Form::kBox, material, T_C_S, half, nullptr};
}

Shape capsule(Material material, const Vector3& a_C, const Vector3& b_C, double radius) {
  const Vector3 axis = b_C - a_C;
  const double length = axis.norm();
  const Vector3 z = length > 1e-9 ? Vector3(axis / length) : Vector3::UnitZ();
  return {Form::kCapsule,
          material,
          {Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), z).toRotationMatrix(), 0.5 * (a_C + b_C)},
          {radius, radius, 0.5 * length},
          nullptr};
}

Shape cylinder(Material material, const Pose& T_C_S, double radius, double half_length) {
  return {Form::kCylinder, material, T_C_S, {radius, radius, half_length}, nullptr};
}

}  // namespace armsight::sim
