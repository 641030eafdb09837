// How far is a capsule from things? Signed where a sign costs nothing: a capsule's surface is its segment, fattened by
// the radius, so distances below zero tell how deep the segment's own fat is in; a segment inside a box gives −radius.
// All in one frame, metres. Exact but for rounding: no iteration, no heap.
#pragma once

#include "shared/geometry.hpp"

namespace armsight {

/// All points within radius_m of the segment from a to b; a == b is a ball.
struct Capsule {
  Vector3 a_m = Vector3::Zero(), b_m = Vector3::Zero();
  double radius_m = 0.0;
};

/// The forbidden side: n · p < offset_m, n of length 1.
struct HalfSpace {
  Vector3 normal = Vector3::UnitZ();
  double offset_m = 0.0;
};

/// The forbidden inside of a box: X in its middle, axes along its edges.
struct KeepOutBox {
  Pose T_B_X;
  Vector3 half_size_m = Vector3::Zero();
};

double distance_m(const Capsule& x, const Capsule& y);
double distance_m(const Capsule& x, const HalfSpace& space);
double distance_m(const Capsule& x, const KeepOutBox& box);

/// Of two segments, of a segment and a box about the origin: what the above are made of.
double segment_distance_m(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);
double segment_box_distance_m(const Vector3& a, const Vector3& b, const Vector3& half_size_m);

}  // namespace armsight
