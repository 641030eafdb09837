// What strict_yaml.cpp makes of a file and strict_yaml_value.cpp answers from: a plain tree with places, no yaml-cpp.
#pragma once

#include "protocol/strict_yaml.hpp"

namespace armsight {

struct YamlPlace {
  int line = 1, column = 1;
};

struct YamlViolation {
  YamlPlace place;
  std::string text;
};

/// "a.b", or "b" at the root.
std::string join_path(const std::string& path, std::string_view name);
/// Only what fits a line of a message.
std::string shown(const std::string& value);

struct YamlValue::Node {
  enum class Kind { kNull, kScalar, kList, kMap };
  struct Entry {
    std::string name;
    YamlPlace place;
    std::unique_ptr<Node> value;
    bool is_used = false;
  };

  Kind kind = Kind::kNull;
  YamlPlace place;
  std::string scalar;
  bool is_quoted = false;
  std::vector<std::unique_ptr<Node>> elements;
  std::vector<Entry> entries;
  Entry* find(std::string_view name) {
    for (Entry& e : entries)
      if (e.name == name) return &e;
    return nullptr;
  }
  bool is_visited = false;  ///< somebody asked for something inside, so the rest inside is unknown
  bool may_have_others = false;  ///< its unknown keys are somebody else's
};

struct YamlValue::Document {
  std::string file_name;
  std::unique_ptr<Node> root;
  std::vector<YamlViolation> violations;

  std::string line_of(YamlPlace place, const std::string& rule) const {
    return file_name + ":" + std::to_string(place.line) + ":" + std::to_string(place.column) + ": " + rule;
  }
  void find_unknown(const Node& node, const std::string& path);
};

}  // namespace armsight
