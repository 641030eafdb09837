// Typed answers from the tree, each with its rule.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>

#include "protocol/strict_yaml_tree.hpp"

namespace armsight {

namespace {

constexpr std::size_t kMaxTextSize = 256;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

std::string to_text(double value) {
  char raw[32];
  std::snprintf(raw, sizeof raw, "%.12g", value);
  return raw;
}

template <typename T>
std::optional<T> parse_number(std::string_view text, int base = 10) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  std::from_chars_result result{};
  if constexpr (std::is_floating_point_v<T>) result = std::from_chars(text.data(), text.data() + text.size(), value);
  else result = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

bool YamlValue::exists() const { return node_ != nullptr; }

int YamlValue::line() const { return node_ == nullptr ? 0 : node_->place.line; }
int YamlValue::column() const { return node_ == nullptr ? 0 : node_->place.column; }

void YamlValue::ignore_other_keys() const {
  if (node_ != nullptr) node_->may_have_others = true;
}

void YamlValue::refuse(const std::string& rule) const {
  if (node_ == nullptr) return;  // its absence has been told
  std::string name = path_.empty() ? "the file" : path_;
  if (node_->kind == Node::Kind::kScalar) name += " = " + shown(node_->scalar);
  document_->violations.push_back({node_->place, name + ": " + rule});
}

YamlValue YamlValue::find(std::string_view name, bool is_required) const {
  const YamlValue absent{document_, nullptr, join_path(path_, name)};
  if (node_ == nullptr) return absent;
  if (node_->kind != Node::Kind::kMap) {
    if (!node_->is_visited) refuse("must be a mapping with keys such as " + std::string(name));
    node_->is_visited = true;
    return absent;
  }
  node_->is_visited = true;
  if (Node::Entry* entry = node_->find(name)) {
    entry->is_used = true;
    return {document_, entry->value.get(), join_path(path_, name)};
  }
  if (is_required) document_->violations.push_back({node_->place, join_path(path_, name) + ": missing"});
  return absent;
}

YamlValue YamlValue::key(std::string_view name) const { return find(name, true); }
YamlValue YamlValue::optional_key(std::string_view name) const { return find(name, false); }

std::vector<std::pair<std::string, YamlValue>> YamlValue::entries() const {
  std::vector<std::pair<std::string, YamlValue>> out;
  if (node_ == nullptr) return out;
  node_->is_visited = true;
  if (node_->kind != Node::Kind::kMap) {
    refuse("must be a mapping");
    return out;
  }
  for (Node::Entry& e : node_->entries) {
    e.is_used = true;
    out.emplace_back(e.name, YamlValue{document_, e.value.get(), join_path(path_, shown(e.name))});
  }
  return out;
}

std::vector<YamlValue> YamlValue::list(std::size_t min_size, std::size_t max_size) const {
  std::vector<YamlValue> out;
  if (node_ == nullptr) return out;
  node_->is_visited = true;
  const std::string range = min_size == max_size ? std::to_string(min_size)
                                                 : std::to_string(min_size) + " to " + std::to_string(max_size);
  if (node_->kind != Node::Kind::kList) {
    refuse("must be a list of " + range);
    return out;
  }
  const std::size_t size = node_->elements.size();
  if (size < min_size || size > max_size) {
    refuse("has " + std::to_string(size) + " entries, must have " + range);
    return out;
  }
  for (std::size_t i = 0; i < size; ++i)
    out.push_back({document_, node_->elements[i].get(), path_ + "[" + std::to_string(i) + "]"});
  return out;
}

std::optional<std::string> YamlValue::scalar(const char* expected) const {
  if (node_ == nullptr) return std::nullopt;
  if (node_->kind == Node::Kind::kScalar) return node_->scalar;
  refuse(std::string("must be ") + expected);
  return std::nullopt;
}

std::optional<double> YamlValue::finite() const {
  const auto text = scalar("a number");
  if (!text) return std::nullopt;
  const auto value = parse_number<double>(*text);
  const bool is_special = *text == ".nan" || *text == ".NaN" || *text == ".inf" || *text == "-.inf";
  if (node_->is_quoted || (!value && !is_special)) refuse("must be a number");
  else if (is_special || !std::isfinite(*value)) refuse("must be finite");
  else return value;
  return std::nullopt;
}

double YamlValue::number(double min, double max) const {
  const auto value = finite();
  if (!value) return kNothing;
  if (*value >= min && *value <= max) return *value;
  refuse("must be between " + to_text(min) + " and " + to_text(max));
  return kNothing;
}

double YamlValue::positive(double max) const {
  const auto value = finite();
  if (!value) return kNothing;
  if (*value > 0 && *value <= max) return *value;
  refuse(*value > 0 ? "must be at most " + to_text(max) : "must be > 0");
  return kNothing;
}

std::vector<double> YamlValue::numbers(std::size_t size, double min, double max) const {
  std::vector<double> out;
  for (const YamlValue& element : list(size, size)) out.push_back(element.number(min, max));
  out.resize(size, kNothing);
  return out;
}

std::optional<std::int64_t> YamlValue::valid_integer(std::int64_t min, std::int64_t max) const {
  const auto text = scalar("a whole number");
  if (!text) return std::nullopt;
  const auto value = parse_number<std::int64_t>(*text);
  if (node_->is_quoted || !value) refuse("must be a whole number");
  else if (*value < min || *value > max)
    refuse("must be between " + std::to_string(min) + " and " + std::to_string(max));
  else return value;
  return std::nullopt;
}

std::int64_t YamlValue::integer(std::int64_t min, std::int64_t max) const {
  return valid_integer(min, max).value_or(min);
}

std::uint64_t YamlValue::unsigned_integer() const {
  const auto text = scalar("a whole number");
  if (!text) return 0;
  const auto value = parse_number<std::uint64_t>(*text);
  if (!node_->is_quoted && value) return *value;
  refuse("must be a whole number, not negative");
  return 0;
}

std::uint64_t YamlValue::hexadecimal() const {
  const auto text = scalar("a number such as 0x1a2b");
  if (!text) return 0;
  if (text->starts_with("0x"))
    if (const auto value = parse_number<std::uint64_t>(std::string_view(*text).substr(2), 16)) return *value;
  refuse("must be a number such as 0x1a2b");
  return 0;
}

bool YamlValue::boolean() const {
  const auto text = scalar("true or false");
  if (!text) return false;
  if (!node_->is_quoted && (*text == "true" || *text == "false")) return *text == "true";
  refuse("must be true or false");
  return false;
}

std::string YamlValue::text() const {
  const auto value = scalar("text");
  if (!value) return "";
  if (value->empty() || value->size() > kMaxTextSize) refuse("must be 1 to 256 bytes of text");
  return *value;
}

}  // namespace armsight
