// Grey levels of what a ray meets: a lamp, light from the ceiling, materials, and the room behind everything.
#pragma once

#include "tools/sim/scene.hpp"
#include "tools/sim/shapes.hpp"

namespace armsight::sim {

/// Everything in C but the poses named otherwise.
struct Stage {
  Vector3 lamp = Vector3::UnitY();    ///< unit, towards the lamp
  Vector3 up = Vector3::UnitY();      ///< unit, against gravity
  Pose T_T_C;                         ///< C in the table's frame (x right, y forward, z up)
  Pose T_T_O;                         ///< the object on the table, for its shadow
  double object_radius_m = 0.0;
  double object_half_height_m = 0.0;
};

/// Grey level of the point t·d on the shape; `module`: of the print there, if it is printed on.
double shade(const Stage& stage, const Shape& shape, const Vector3& p_C, const Vector3& p_S, int part,
             std::optional<bool> module);
/// The room along the ray: a floor, and walls in the haze.
double shade_room(const Stage& stage, const Vector3& d_C);

}  // namespace armsight::sim
