#include "tools/sim/shading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace armsight::sim {
namespace {

constexpr double kWhiteLevel = 250.0;  // of a white surface in full light

/// Repeatable value noise in [-1, 1], smooth over the unit lattice.
double lattice(int x, int y) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  return static_cast<double>(h & 0xFFFFU) / 32767.5 - 1.0;
}

double smooth_noise(double x, double y) {
  const double fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  double u = x - fx, v = y - fy;
  u *= u * (3.0 - 2.0 * u);
  v *= v * (3.0 - 2.0 * v);
  const double a = lattice(ix, iy) * (1.0 - u) + lattice(ix + 1, iy) * u;
  const double b = lattice(ix, iy + 1) * (1.0 - u) + lattice(ix + 1, iy + 1) * u;
  return a * (1.0 - v) + b * v;
}

/// Boards 45 mm wide across y with grain along x.
double wood_albedo(double x, double y) {
  const double board = std::floor(y / 0.045);
  const double tone = 0.05 * lattice(static_cast<int>(board), 7);
  const double grain = smooth_noise(x * 9.0 + board * 31.0, y * 420.0) * 0.6 + smooth_noise(x * 40.0, y * 1500.0) * 0.4;
  const double wave = std::sin(60.0 * y + 5.0 * smooth_noise(x * 6.0 + board * 13.0, y * 14.0));
  const double seam = std::abs(y / 0.045 - board - 0.5) > 0.485 ? -0.16 : 0.0;
  return 0.42 + tone + 0.045 * grain + 0.02 * wave + seam;
}

/// A printed can: steel rims, a dark sleeve with a light band and lettering-like marks.
double can_albedo(const Vector3& p_S, double half_height) {
  const double z = p_S.z() / half_height;
  if (std::abs(z) > 0.93) return 0.72;
  const double turn = std::atan2(p_S.y(), p_S.x()) / std::numbers::pi;
  if (z > 0.18 && z < 0.62) {
    const double u = turn * 16.0, cell = u - std::floor(u);
    const bool is_mark =
        z > 0.30 && z < 0.50 && cell > 0.22 && cell < 0.62 + 0.3 * lattice(static_cast<int>(std::floor(u)), 3);
    return is_mark ? 0.16 : 0.66;
  }
  if (std::abs(z + 0.45) < 0.03) return 0.6;
  return 0.24 + 0.02 * smooth_noise(turn * 9.0, z * 5.0);
}

struct Surface {
  double albedo = 0.5;
  double gloss = 0.0;
  int sharpness = 4;  ///< highlight: cosine to the power of 2^sharpness
};

Surface surface_of(const Shape& shape, const Vector3& p_S, int part, std::optional<bool> module) {
  switch (shape.material) {
    case Material::kWood: return {part == kTop ? wood_albedo(p_S.x(), p_S.y()) : 0.30, 0.05, 3};
    case Material::kSteel: return {0.35, 0.25, 5};
    case Material::kCan: return {part == 0 ? can_albedo(p_S, shape.size.z()) : 0.6, 0.28, 5};
    case Material::kWhitePlate: return {module ? (*module ? 0.86 : 0.06) : (part == kTop ? 0.86 : 0.55), 0.0, 0};
    case Material::kGraphite: return {0.15, 0.16, 4};
    case Material::kShell: return {0.62, 0.14, 5};
    case Material::kRubber: return {0.10, 0.04, 3};
  }
  return {};
}

/// Part of the lamp that the object hides from a point of the table's top; the lamp is a disc, so the edge is soft.
double object_shadow(const Stage& stage, const Vector3& p_T) {
  const Vector3 p_O = stage.T_T_O.inverse() * p_T;
  if (p_O.head<2>().norm() > 0.35) return 0.0;
  const Matrix3 R_O_C = (stage.T_T_O.inverse() * stage.T_T_C).R;
  const Vector3 lamp_O = R_O_C * stage.lamp;
  const Vector3 u = lamp_O.unitOrthogonal(), v = lamp_O.cross(u);
  const Shape object{Form::kCylinder,
                     Material::kCan,
                     {},
                     {stage.object_radius_m, stage.object_radius_m, stage.object_half_height_m},
                     nullptr};
  constexpr int kRays = 24;
  int hidden = 0;
  for (int i = 0; i < kRays; ++i) {
    const double r = 0.13 * std::sqrt((i + 0.5) / kRays), a = 2.399963 * i;  // golden angle
    hidden += meet(object, p_O, lamp_O + r * (std::cos(a) * u + std::sin(a) * v)) > 0.0 ? 1 : 0;
  }
  return static_cast<double>(hidden) / kRays;
}

/// Ceiling light that the object keeps from the table close to its foot.
double object_contact(const Stage& stage, const Vector3& p_T) {
  const double away = (p_T - stage.T_T_O.p).head<2>().norm() - stage.object_radius_m;
  return 0.55 * std::exp(-std::max(away, 0.0) / 0.018);
}

}  // namespace

double shade(const Stage& stage, const Shape& shape, const Vector3& p_C, const Vector3& p_S, int part,
             std::optional<bool> module) {
  const Surface surface = surface_of(shape, p_S, part, module);
  const Vector3 n = shape.T_C_S.R * normal_S(shape, p_S, part);
  double lamp = std::max(0.0, n.dot(stage.lamp));
  double ceiling = 0.40 + 0.12 * n.dot(stage.up);
  if (shape.material == Material::kWood && part == kTop) {
    const Vector3 p_T = stage.T_T_C * p_C;
    lamp *= 1.0 - object_shadow(stage, p_T);
    ceiling *= 1.0 - object_contact(stage, p_T);
  }
  const double matt = surface.albedo * (ceiling + 0.66 * lamp);
  if (surface.gloss == 0.0 || lamp == 0.0) return kWhiteLevel * matt;
  double gloss = std::max(0.0, n.dot((stage.lamp - p_C.normalized()).normalized()));  // Blinn's half vector
  for (int i = 0; i < surface.sharpness; ++i) gloss *= gloss;
  return kWhiteLevel * (matt + surface.gloss * gloss);
}

double shade_room(const Stage& stage, const Vector3& d_C) {
  constexpr double kFloorBelowTable = 0.72, kWall = 2.2;
  const Vector3 eye = stage.T_T_C.p, d = (stage.T_T_C.R * d_C).normalized();
  const double to_floor = d.z() < -1e-4 ? (-kFloorBelowTable - eye.z()) / d.z() : 1e9;
  const double level_speed = std::max(d.head<2>().cwiseAbs().maxCoeff(), 1e-6);  // square room
  const double to_wall = kWall / level_speed;
  if (to_floor < to_wall) {
    const Vector3 p = eye + to_floor * d;
    const double tile_x = p.x() / 0.40 - std::floor(p.x() / 0.40), tile_y = p.y() / 0.40 - std::floor(p.y() / 0.40);
    const double joint = tile_x < 0.015 || tile_y < 0.015 ? -0.05 : 0.0;
    const double speckle =
        0.012 * smooth_noise(p.x() * 90.0, p.y() * 90.0) + 0.02 * smooth_noise(p.x() * 5.0, p.y() * 5.0);
    const double under = std::exp(-p.head<2>().squaredNorm() / 0.08);  // the table keeps the light off
    const double corner = std::exp(-(kWall - std::min(to_floor * level_speed, kWall)) / 0.25);
    return kWhiteLevel * (0.30 + joint + speckle) * (1.0 - 0.35 * under) * (1.0 - 0.25 * corner);
  }
  const double height = eye.z() + to_wall * d.z() + kFloorBelowTable;
  const double skirting = height < 0.09 ? -0.16 : 0.0;
  return kWhiteLevel *
         (0.50 + skirting + 0.06 * std::tanh(height - 0.8) + 0.008 * smooth_noise(d.x() * 40.0, height * 20.0)) *
         (1.0 - 0.25 * std::exp(-std::max(height, 0.0) / 0.20));
}

}  // namespace armsight::sim
