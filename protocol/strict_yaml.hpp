// YAML read strictly: every value is asked for with its type and range, and all violations are told at once as
// "file:line:column: key = value: rule". What nobody asked for is an unknown key. yaml-cpp stays in strict_yaml.cpp.
//
//   StrictYaml yaml = StrictYaml::parse(text, "robot.yaml");
//   const double period_s = yaml.root().key("controller").key("period_s").number(0.001, 0.1);
//   yaml.finish();                                 // throws ConfigError with the whole list
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/config_error.hpp"

namespace armsight {

class StrictYaml;

/// A value at its place. Asking a missing or wrong one records a violation and answers NaN, zero, the minimum or an
/// empty text, so reading goes on and finds the others; finish() throws them.
class YamlValue {
 public:
  /// False for an optional key that is absent; also where a violation was recorded already.
  bool exists() const;
  /// Entry of a mapping; its absence is a violation.
  YamlValue key(std::string_view name) const;
  /// Entry of a mapping that may be absent: see exists().
  YamlValue optional_key(std::string_view name) const;
  /// All entries of a mapping with free names, in the order of the file.
  std::vector<std::pair<std::string, YamlValue>> entries() const;
  /// Elements of a list with min … max of them.
  std::vector<YamlValue> list(std::size_t min_size, std::size_t max_size) const;

  /// Finite, inside [min, max].
  double number(double min, double max) const;
  /// Finite and > 0, at most max.
  double positive(double max) const;
  /// A list of exactly `size` numbers inside [min, max].
  std::vector<double> numbers(std::size_t size, double min, double max) const;
  std::int64_t integer(std::int64_t min, std::int64_t max) const;
  /// nullopt: a violation was recorded.
  std::optional<std::int64_t> valid_integer(std::int64_t min, std::int64_t max) const;
  std::uint64_t unsigned_integer() const;
  /// Hexadecimal with the prefix 0x, as model hashes are written.
  std::uint64_t hexadecimal() const;
  bool boolean() const;
  /// Not empty, at most 256 bytes.
  std::string text() const;

  /// For files in formats of others: keys of this mapping that nobody asked for are no violation.
  void ignore_other_keys() const;
  /// Records a violation of a rule that only the reader knows: "<place>: key = value: <rule>".
  void refuse(const std::string& rule) const;
  const std::string& path() const { return path_; }
  /// Where it begins in the file, from 1, in bytes; 0: absent.
  int line() const;
  int column() const;

 private:
  friend class StrictYaml;
  friend class YamlTreeBuilder;
  struct Node;
  struct Document;
  YamlValue(std::shared_ptr<Document> document, Node* node, std::string path)
      : document_(std::move(document)), node_(node), path_(std::move(path)) {}
  std::optional<std::string> scalar(const char* expected) const;
  std::optional<double> finite() const;
  YamlValue find(std::string_view name, bool is_required) const;

  std::shared_ptr<Document> document_;
  Node* node_;  ///< nullptr: absent
  std::string path_;
};

class StrictYaml {
 public:
  /// Throws ConfigError on text that is no YAML, on more than one document, beyond 1 MiB, 20 levels or 100 000 values.
  static StrictYaml parse(std::string_view text, const std::string& file_name);
  YamlValue root() const;
  /// Adds keys nobody asked for; throws ConfigError if there is any violation, in the order of the file.
  void finish() const;

 private:
  explicit StrictYaml(std::shared_ptr<YamlValue::Document> document) : document_(std::move(document)) {}
  std::shared_ptr<YamlValue::Document> document_;
};

/// The whole file; throws ConfigError "FILE: cannot be read: reason".
std::string read_text_file(const std::filesystem::path& file);

}  // namespace armsight
