#include "host/grasp_table.hpp"

#include <utility>

#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

constexpr double kMaxOffset_m = 1.0;
constexpr std::size_t kMaxGrasps = 64;
constexpr std::int64_t kMaxMarkerId = 1023;
constexpr double kRotationTolerance = 1e-4;

Vector3 read_vector(const YamlValue& value) {
  const std::vector<double> v = value.numbers(3, -kMaxOffset_m, kMaxOffset_m);
  return {v[0], v[1], v[2]};
}

Pose read_pose(const YamlValue& owner) {
  Pose T;
  T.p = read_vector(owner.key("position_m"));
  const YamlValue rows = owner.key("rotation_rows");
  const std::vector<YamlValue> lines = rows.list(3, 3);
  for (std::size_t r = 0; r < lines.size() && r < 3; ++r) {
    const std::vector<double> v = lines[r].numbers(3, -1.0, 1.0);
    T.R.row(static_cast<Eigen::Index>(r)) << v[0], v[1], v[2];
  }
  if (rows.exists() && !is_rotation(T.R, kRotationTolerance)) {
    rows.refuse("must be a rotation: orthonormal rows, determinant +1");
    return T;
  }
  T.R = nearest_rotation(T.R);
  return T;
}

GraspEntry read_grasp(const YamlValue& value) {
  GraspEntry grasp;
  grasp.name = value.key("name").text();
  grasp.T_H_O = read_pose(value);
  grasp.has_free_yaw = value.key("free_yaw").boolean();
  grasp.retreat_m = read_vector(value.key("retreat_m"));
  return grasp;
}

GraspObject read_object(const std::string& name, const YamlValue& value) {
  GraspObject object;
  object.name = name;
  const YamlValue marker = value.key("marker");
  object.marker.dictionary = marker.key("dictionary").text();
  object.marker.id = static_cast<int>(marker.key("id").integer(0, kMaxMarkerId));
  object.marker.side_m = marker.key("side_m").positive(1.0);
  object.T_O_M = read_pose(marker);
  const YamlValue hand = value.key("hand");
  object.force_limit_permille = hand.key("force_limit_permille").number(1.0, 1000.0);
  object.grasped_below_closure = hand.key("grasped_below_closure").number(0.05, 0.999);
  const YamlValue tolerance = value.key("tolerance");
  object.position_tolerance_m = tolerance.key("position_m").positive(0.05);
  object.orientation_tolerance_rad = tolerance.key("orientation_rad").positive(0.5);
  for (const YamlValue& grasp : value.key("grasps").list(1, kMaxGrasps)) object.grasps.push_back(read_grasp(grasp));
  return object;
}

}  // namespace

Pose GraspEntry::T_O_G(double yaw_rad) const {
  return Pose{so3_exp(Vector3(0, 0, yaw_rad)), Vector3::Zero()} * T_H_O.inverse();
}

Pose GraspEntry::pregrasp(const Pose& T_X_G) const { return T_X_G * Pose{Matrix3::Identity(), retreat_m}; }

GraspTable GraspTable::load(const std::filesystem::path& file) { return parse(read_text_file(file), file.string()); }

GraspTable GraspTable::parse(std::string_view text, const std::string& file_name) {
  GraspTable table;
  table.file_name_ = file_name;
  const StrictYaml yaml = StrictYaml::parse(text, file_name);
  const YamlValue objects = yaml.root().key("objects");
  const auto entries = objects.entries();
  for (const auto& [name, value] : entries) table.objects_.emplace(name, read_object(name, value));
  if (objects.exists() && entries.empty()) objects.refuse("must name at least one object");
  yaml.finish();
  return table;
}

const GraspObject& GraspTable::find(const std::string& name) const {
  const auto found = objects_.find(name);
  if (found != objects_.end()) return found->second;
  std::string known;
  for (const auto& [other, object] : objects_) known += (known.empty() ? "" : ", ") + other;
  throw ConfigError("--object: " + name + ": must be an object of " + file_name_ + " (" + known + ")");
}

}  // namespace armsight::host
