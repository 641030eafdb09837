// The look-up table of grasps (specification F-P11): object name → its marker and the ways to hold it.
// The file is YAML, read strictly: all violations at once with line and column.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/config.hpp"

namespace armsight::host {

/// One way to hold an object.
struct GraspEntry {
  std::string name;
  Pose T_H_O;          ///< the object seen from the hand that holds it
  bool has_free_yaw = false;  ///< any turn about z_O is as good
  Vector3 retreat_m;   ///< from the grasp to the pre-grasp, in H

  /// Goal of the hand in O, turned by yaw about z_O.
  Pose T_O_G(double yaw_rad) const;
  /// The same, drawn back.
  Pose pregrasp(const Pose& T_X_G) const;
};

struct GraspObject {
  std::string name;
  MarkerConfig marker;
  Pose T_O_M;
  double force_limit_permille = 0.0;
  double grasped_below_closure = 0.0;
  double position_tolerance_m = 0.0, orientation_tolerance_rad = 0.0;
  std::vector<GraspEntry> grasps;
};

class GraspTable {
 public:
  /// Throws ConfigError.
  static GraspTable load(const std::filesystem::path& file);
  static GraspTable parse(std::string_view text, const std::string& file_name);

  /// Throws ConfigError that lists the known names.
  const GraspObject& find(const std::string& name) const;
  const std::map<std::string, GraspObject>& objects() const { return objects_; }

 private:
  std::map<std::string, GraspObject> objects_;
  std::string file_name_;
};

}  // namespace armsight::host
