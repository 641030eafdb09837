#include "protocol/strict_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "protocol/strict_yaml_tree.hpp"

namespace armsight {

namespace {

constexpr std::size_t kMaxBytes = 1024 * 1024, kMaxDepth = 20, kMaxValues = 100000;

YamlPlace place_of(const YAML::Node& node, YamlPlace fallback) {
  const YAML::Mark mark = node.Mark();
  return mark.line < 0 ? fallback : YamlPlace{mark.line + 1, mark.column + 1};
}

}  // namespace

std::string join_path(const std::string& path, std::string_view name) {
  return path.empty() ? std::string(name) : path + "." + std::string(name);
}

std::string shown(const std::string& value) {
  std::string out = value.size() <= 60 ? value : value.substr(0, 57) + "...";
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  return out;
}

/// yaml-cpp's nodes → our tree. Aliases may point at their own ancestors or multiply without end, so depth and number
/// are bounded.
class YamlTreeBuilder {
 public:
  using Node = YamlValue::Node;
  explicit YamlTreeBuilder(YamlValue::Document& document) : document_(document) {}

  std::unique_ptr<Node> convert(const YAML::Node& in, std::size_t depth, YamlPlace fallback, const std::string& path) {
    auto out = std::make_unique<Node>();
    out->place = place_of(in, fallback);
    if (depth > kMaxDepth) fail(out->place, path + ": nested deeper than " + std::to_string(kMaxDepth) + " levels");
    if (++values_ > kMaxValues) fail(out->place, path + ": more than " + std::to_string(kMaxValues) + " values");
    if (in.IsScalar()) {
      out->kind = Node::Kind::kScalar;
      out->scalar = in.Scalar();
      out->is_quoted = in.Tag() == "!";
    } else if (in.IsSequence()) {
      out->kind = Node::Kind::kList;
      for (const YAML::Node& element : in)
        out->elements.push_back(
            convert(element, depth + 1, out->place, path + "[" + std::to_string(out->elements.size()) + "]"));
    } else if (in.IsMap()) {
      convert_map(in, *out, depth, path);
    }
    return out;
  }

  [[noreturn]] void fail(YamlPlace place, const std::string& rule) const {
    throw ConfigError(document_.line_of(place, rule));
  }

 private:
  // yaml-cpp keeps repeated keys and would answer the first: only the iteration shows them.
  void convert_map(const YAML::Node& in, Node& out, std::size_t depth, const std::string& path) {
    out.kind = Node::Kind::kMap;
    for (const auto& pair : in) {
      const YamlPlace place = place_of(pair.first, out.place);
      if (!pair.first.IsScalar()) fail(place, join_path(path, "?") + ": a key must be plain text");
      const std::string& name = pair.first.Scalar();
      const std::string key_path = join_path(path, shown(name));
      auto value = convert(pair.second, depth + 1, place, key_path);
      if (const Node::Entry* first = out.find(name))
        document_.violations.push_back(
            {place, key_path + ": repeated key, first at line " + std::to_string(first->place.line)});
      else
        out.entries.push_back({name, place, std::move(value), false});
    }
  }

  YamlValue::Document& document_;
  std::size_t values_ = 0;
};

void YamlValue::Document::find_unknown(const Node& node, const std::string& path) {
  if (!node.is_visited) return;
  for (const Node::Entry& e : node.entries) {
    if (e.is_used) find_unknown(*e.value, join_path(path, e.name));
    else if (!node.may_have_others)
      violations.push_back({e.place, join_path(path, shown(e.name)) + ": unknown key"});
  }
  for (std::size_t i = 0; i < node.elements.size(); ++i)
    find_unknown(*node.elements[i], path + "[" + std::to_string(i) + "]");
}

StrictYaml StrictYaml::parse(std::string_view text, const std::string& file_name) {
  auto document = std::make_shared<YamlValue::Document>();
  document->file_name = file_name;
  YamlTreeBuilder builder(*document);
  if (text.size() > kMaxBytes) builder.fail({}, "longer than 1 MiB");
  if (text.find('\0') != std::string_view::npos) builder.fail({}, "not a text file: holds a zero byte");
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(std::string(text));
    if (documents.empty()) builder.fail({}, "empty file");
    if (documents.size() > 1) builder.fail(place_of(documents[1], {}), "more than one YAML document");
    document->root = builder.convert(documents[0], 0, {}, "");
  } catch (const YAML::Exception& e) {
    builder.fail(e.mark.is_null() ? YamlPlace{} : YamlPlace{e.mark.line + 1, e.mark.column + 1}, "not YAML: " + e.msg);
  }
  return StrictYaml(document);
}

YamlValue StrictYaml::root() const { return {document_, document_->root.get(), ""}; }

void StrictYaml::finish() const {
  document_->find_unknown(*document_->root, "");
  auto& violations = document_->violations;
  if (violations.empty()) return;
  std::stable_sort(violations.begin(), violations.end(), [](const YamlViolation& a, const YamlViolation& b) {
    return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
  });
  std::string text;
  for (const YamlViolation& v : violations) {
    if (!text.empty()) text += '\n';
    text += document_->line_of(v.place, v.text);
  }
  throw ConfigError(text);
}

std::string read_text_file(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw ConfigError(file.string() + ": cannot be read: is a folder");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(file.string() + ": cannot be read: " + std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw ConfigError(file.string() + ": cannot be read to its end");
  return text;
}

}  // namespace armsight
