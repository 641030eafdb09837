#include "tools/sim/solids.hpp"

#include <cmath>

namespace armsight::sim {
namespace {

constexpr double kForearm_m = 0.185;  // d5 of the arm (specification §4.1)

/// A finger of three rods that bends in the plane of its direction and the palm's normal.
void add_finger(const Pose& T_C_H, const Vector3& base_H, const Vector3& along_H, const std::array<double, 3>& lengths,
                const std::array<double, 3>& bends, double radius, std::vector<Shape>& out) {
  Vector3 from = base_H;
  double angle = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    angle += bends[i];
    const Vector3 to = from + lengths[i] * (std::cos(angle) * along_H + std::sin(angle) * Vector3::UnitX());
    out.push_back(capsule(Material::kShell, T_C_H * from, T_C_H * to, radius * (1.0 - 0.08 * static_cast<double>(i))));
    const Vector3 cushion = 0.0035 * (-std::sin(angle) * along_H + std::cos(angle) * Vector3::UnitX());
    out.push_back(capsule(Material::kRubber, T_C_H * (from + 0.3 * (to - from) + cushion),
                          T_C_H * (from + 0.85 * (to - from) + cushion), radius * 0.72));
    from = to;
  }
}

}  // namespace

void add_arm(const Pose& T_C_B, const Pose& T_B_H, std::vector<Shape>& out) {
  const Pose T_C_H = T_C_B * T_B_H;
  const auto along = [&](double y) { return T_C_H * Vector3(0, y, 0); };
  out.push_back(capsule(Material::kGraphite, along(0.012), along(0.03), 0.0165));
  out.push_back(capsule(Material::kShell, along(0.052), along(kForearm_m - 0.045), 0.0290));
  out.push_back(capsule(Material::kGraphite, along(0.046), along(0.050), 0.0270));
  const Vector3 elbow = along(kForearm_m), shoulder = T_C_B.p;
  const Vector3 up = (shoulder - elbow).normalized();
  const Vector3 y_C = T_C_H.R.col(1);
  Vector3 hinge = y_C.cross(up);
  hinge = hinge.norm() > 1e-3 ? hinge.normalized() : Vector3(T_C_H.R.col(0));
  out.push_back(capsule(Material::kGraphite, elbow - 0.024 * hinge, elbow + 0.024 * hinge, 0.0255));
  out.push_back(capsule(Material::kShell, elbow + 0.045 * up, shoulder - 0.03 * up, 0.033));
}

void add_hand(const Pose& T_C_H, double closure, std::vector<Shape>& out) {
  const auto in_hand = [&](const Vector3& p) { return T_C_H * Pose{Matrix3::Identity(), p}; };
  out.push_back(box(Material::kGraphite, in_hand({0.001, -0.042, 0.0}), {0.0125, 0.036, 0.034}));
  for (const double z : {-0.034, 0.034}) {
    out.push_back(
        capsule(Material::kGraphite, T_C_H * Vector3(0.001, -0.010, z), T_C_H * Vector3(0.001, -0.074, z), 0.0125));
  }
  out.push_back(capsule(Material::kGraphite, T_C_H * Vector3(0.001, -0.076, -0.034),
                        T_C_H * Vector3(0.001, -0.076, 0.034), 0.0125));
  out.push_back(box(Material::kRubber, in_hand({0.0155, -0.030, 0.0}), {0.003, 0.022, 0.022}));
  for (const double z : {-0.036, -0.0125, 0.0125, 0.036}) {
    const double shorter = std::abs(z) > 0.03 ? 0.88 : 1.0;
    add_finger(T_C_H, {0.002, -0.088, z}, {0.0, -1.0, 0.0}, {0.034 * shorter, 0.026 * shorter, 0.020 * shorter},
               {0.06 + 0.85 * closure, 0.10 + 1.10 * closure, 0.08 + 0.75 * closure}, 0.0088, out);
  }
  const Vector3 thumb = Vector3(0.0, -0.62, 0.78).normalized();
  out.push_back(
      capsule(Material::kGraphite, T_C_H * Vector3(0.0, -0.022, 0.036), T_C_H * Vector3(0.0, -0.030, 0.046), 0.0115));
  add_finger(T_C_H, {0.001, -0.030, 0.046}, thumb, {0.030, 0.026, 0.019},
             {0.05 + 0.9 * closure, 0.05 + 0.7 * closure, 0.05 + 0.5 * closure}, 0.0095, out);
}

void add_plate(const Pose& T_C_M, double side_m, std::shared_ptr<const MarkerPrint> print, std::vector<Shape>& out) {
  constexpr double kHalfThickness = 0.0010;
  const double h = 0.5 * side_m;
  Shape plate =
      box(Material::kWhitePlate, T_C_M * Pose{Matrix3::Identity(), {0, 0, -kHalfThickness}}, {h, h, kHalfThickness});
  plate.print = std::move(print);
  out.push_back(std::move(plate));
}

void add_object(const Pose& T_C_O, const SceneObject& object, std::shared_ptr<const MarkerPrint> print,
                std::vector<Shape>& out) {
  out.push_back(cylinder(Material::kCan, T_C_O, object.radius_m, 0.5 * object.height_m));
  const double half = 0.5 * (object.marker_height_m - 0.5 * object.height_m);
  if (half <= 0.0) return;
  Shape label = cylinder(Material::kWhitePlate, T_C_O * Pose{Matrix3::Identity(), {0, 0, 0.5 * object.height_m + half}},
                         object.radius_m - 0.0004, half);
  label.print = std::move(print);
  out.push_back(std::move(label));
}

Pose table_top(const Scene& scene, const Pose& T_B_O) {
  const Vector3 up = T_B_O.R.col(2);
  Vector3 forward = -Vector3::UnitY();  // -y0 (specification §4.3)
  forward = (forward - up * up.dot(forward)).normalized();
  const Vector3 right = forward.cross(up);
  Pose T_B_T;
  T_B_T.R << right, forward, up;
  const Vector3 foot = T_B_O.p - 0.5 * scene.object.height_m * up;
  const Vector3 middle =
      scene.object.position_B + scene.table.shift_right_m * right + scene.table.shift_forward_m * forward;
  T_B_T.p = middle + up * up.dot(foot - middle);
  return T_B_T;
}

void add_table(const Pose& T_C_T, const Table& table, std::vector<Shape>& out) {
  const auto below = [&](double x, double y, double depth) {
    return T_C_T * Pose{Matrix3::Identity(), {x, y, -depth}};
  };
  const double half = 0.5 * table.thickness_m;
  out.push_back(box(Material::kWood, below(0, 0, half), {table.half_right_m, table.half_forward_m, half}));
  constexpr double kLegHalf = 0.35;
  out.push_back(cylinder(Material::kSteel, below(0, 0, table.thickness_m + kLegHalf), 0.028, kLegHalf));
}

}  // namespace armsight::sim
