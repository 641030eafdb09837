// The solids a simulated picture is made of, each met by a straight ray in closed form. S is the shape's own frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "shared/geometry.hpp"

namespace armsight::sim {

class MarkerPrint;

enum class Form : std::uint8_t { kBox, kCapsule, kCylinder };  ///< capsule and cylinder stand along z_S
enum class Material : std::uint8_t { kWood, kSteel, kCan, kWhitePlate, kGraphite, kShell, kRubber };

struct Shape {
  Form form = Form::kBox;
  Material material = Material::kGraphite;
  Pose T_C_S;
  Vector3 size = Vector3::Zero();              ///< box: half edges; else radius, radius, half length along z
  std::shared_ptr<const MarkerPrint> print;    ///< on the face +z
};

/// Smallest distance t > 0 with o + t d on the shape (in S); negative: missed.
double meet(const Shape& shape, const Vector3& o_S, const Vector3& d_S);

/// Which smooth piece of the surface a point belongs to: box 0–5 (±x ±y ±z), else 0 side, 4 top, 5 bottom.
int part_of(const Shape& shape, const Vector3& p_S);
inline constexpr int kTop = 4;
Vector3 normal_S(const Shape& shape, const Vector3& p_S, int part);

/// Corners of a box around the shape, in C: what has to be looked at on the picture.
std::array<Vector3, 8> bounds_C(const Shape& shape);

Shape box(Material material, const Pose& T_C_S, const Vector3& half);
/// Rounded rod between two points of C.
Shape capsule(Material material, const Vector3& a_C, const Vector3& b_C, double radius);
Shape cylinder(Material material, const Pose& T_C_S, double radius, double half_length);

}  // namespace armsight::sim
