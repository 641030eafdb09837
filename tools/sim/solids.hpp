// The simulated world as solids before the camera: arm, hand with its plate, object, table.
#pragma once

#include <memory>
#include <vector>

#include "tools/sim/printed_marker.hpp"
#include "tools/sim/scene.hpp"
#include "tools/sim/shapes.hpp"
#include "tools/sim/world_view.hpp"

namespace armsight::sim {

/// Arm and hand, by the hand's pose: forearm along +y_H to the elbow, upper arm from there to B.
void add_arm(const Pose& T_C_B, const Pose& T_B_H, std::vector<Shape>& out);
/// The hand with fingers bent by the closure, 0 open … 1 closed.
void add_hand(const Pose& T_C_H, double closure, std::vector<Shape>& out);
/// The plate with the hand marker.
void add_plate(const Pose& T_C_M, double side_m, std::shared_ptr<const MarkerPrint> print, std::vector<Shape>& out);
void add_object(const Pose& T_C_O, const SceneObject& object, std::shared_ptr<const MarkerPrint> print,
                std::vector<Shape>& out);

/// Middle of the table's top, z against gravity, y forward (away from the robot), x to its right. The table stays where
/// the object stood first; its height is that of the object's foot.
Pose table_top(const Scene& scene, const Pose& T_B_O);
void add_table(const Pose& T_C_T, const Table& table, std::vector<Shape>& out);

}  // namespace armsight::sim
