#include "protocol/config_collision.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "protocol/config_values.hpp"

namespace armsight {
namespace {

constexpr double kFarthest_m = 10.0;

/// A name that is new among all of the section's.
std::string read_name(const YamlValue& entry, CollisionConfig& out, std::vector<std::string>& names) {
  const YamlValue name = entry.key("name");
  const std::string text = name.text();
  for (const auto* taken : {&out.capsules, &out.half_spaces, &out.boxes})
    if (std::find(taken->begin(), taken->end(), text) != taken->end()) name.refuse("name is already taken");
  names.push_back(text);
  return text;
}

void read_capsule(const YamlValue& entry, int joint_count, CollisionConfig& out) {
  read_name(entry, out, out.capsules);
  LinkCapsule& c = out.model.capsules[out.model.capsule_count++];
  c.link = static_cast<int>(entry.key("link").integer(0, joint_count > 0 ? joint_count : kMaxJoints));
  c.capsule.a_m = read_vector(entry.key("from_m"), 2);
  c.capsule.b_m = read_vector(entry.key("to_m"), 2);
  c.capsule.radius_m = entry.key("radius_m").positive(1);
}

void read_half_space(const YamlValue& entry, CollisionConfig& out) {
  read_name(entry, out, out.half_spaces);
  HalfSpace& space = out.model.half_spaces[out.model.half_space_count++];
  const YamlValue normal = entry.key("normal");
  space.normal = read_vector(normal, 1.001);
  if (std::abs(space.normal.norm() - 1.0) > 1e-3)
    normal.refuse("must be of length 1");
  else
    space.normal.normalize();
  space.offset_m = entry.key("offset_m").number(-kFarthest_m, kFarthest_m);
}

void read_box(const YamlValue& entry, CollisionConfig& out) {
  read_name(entry, out, out.boxes);
  KeepOutBox& box = out.model.boxes[out.model.box_count++];
  box.T_B_X = read_pose(entry);
  const YamlValue half = entry.key("half_size_m");
  box.half_size_m = read_vector(half, kFarthest_m);
  if (box.half_size_m.minCoeff() <= 0.0) half.refuse("must be > 0");
}

void read_pair(const YamlValue& entry, CollisionConfig& out) {
  std::array<std::uint8_t, 2> pair{};
  std::size_t k = 0;
  for (const YamlValue& name : entry.list(2, 2)) {
    const auto found = std::find(out.capsules.begin(), out.capsules.end(), name.text());
    if (found == out.capsules.end())
      name.refuse("is the name of no capsule");
    else
      pair[k] = static_cast<std::uint8_t>(found - out.capsules.begin());
    ++k;
  }
  if (k == 2 && pair[0] == pair[1]) entry.refuse("a capsule is always near itself");
  out.model.self_pairs[out.model.pair_count++] = pair;
}

std::string mm(double value_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * value_m);
  return text;
}

const std::string& other_name(const CollisionConfig& collision, const Clearance& nearest) {
  const auto& names = nearest.obstacle == Obstacle::kCapsule     ? collision.capsules
                      : nearest.obstacle == Obstacle::kHalfSpace ? collision.half_spaces
                                                                 : collision.boxes;
  return names.at(nearest.other);
}

}  // namespace

CollisionConfig read_collision(const YamlValue& collision, int joint_count) {
  CollisionConfig out;
  if (!collision.exists()) return out;
  out.model.margin_m = collision.key("margin_m").number(0, 0.2);
  for (const YamlValue& entry : collision.key("capsules").list(1, CollisionModel::kMaxCapsules))
    read_capsule(entry, joint_count, out);
  const YamlValue spaces = collision.optional_key("half_spaces"), boxes = collision.optional_key("boxes");
  const YamlValue pairs = collision.optional_key("self");
  if (spaces.exists())
    for (const YamlValue& entry : spaces.list(0, CollisionModel::kMaxZones)) read_half_space(entry, out);
  if (boxes.exists())
    for (const YamlValue& entry : boxes.list(0, CollisionModel::kMaxZones)) read_box(entry, out);
  if (pairs.exists())
    for (const YamlValue& entry : pairs.list(0, CollisionModel::kMaxPairs)) read_pair(entry, out);
  return out;
}

std::string to_text(const CollisionConfig& collision, const Clearance& nearest) {
  if (nearest.obstacle == Obstacle::kNothing) return "the robot file describes nothing to collide with";
  const std::string &one = collision.capsules.at(nearest.capsule), &other = other_name(collision, nearest);
  const double margin_m = collision.model.margin_m;
  if (nearest.distance_m >= margin_m + kPlanSlack_m)
    return "nearest: " + one + " to " + other + ", " + mm(nearest.distance_m);
  return one + " comes within " + mm(nearest.distance_m) + " of " + other + " (margin " + mm(margin_m) + ")";
}

}  // namespace armsight
