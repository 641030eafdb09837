#include "tools/convert/text_files.hpp"

#include <charconv>
#include <cmath>
#include <fstream>

#include "protocol/strict_yaml.hpp"

namespace armsight::tools {

std::vector<std::string> read_lines(const Path& file) {
  const std::string content = read_text_file(file);
  std::vector<std::string> lines;
  for (std::size_t from = 0; from < content.size();) {
    const std::size_t to = std::min(content.find('\n', from), content.size());
    lines.push_back(content.substr(from, to - from));
    if (!lines.back().empty() && lines.back().back() == '\r') lines.back().pop_back();
    from = to + 1;
  }
  return lines;
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> fields;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(separator, from), text.size());
    std::string_view field = text.substr(from, to - from);
    while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) field.remove_prefix(1);
    while (!field.empty() && (field.back() == ' ' || field.back() == '\t')) field.remove_suffix(1);
    fields.emplace_back(field);
    from = to + 1;
  }
  return fields;
}

std::string join(const std::vector<std::string>& fields) {
  std::string text;
  for (const auto& field : fields) text += (text.empty() ? "" : ",") + field;
  return text;
}

const std::string& checked_number(const std::string& text, const Path& file, std::size_t line) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    refuse(file, line, "'" + text + "' must be a finite number");
  }
  return text;
}

void write_file(const Path& file, const std::string& content) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  std::ofstream out(file, std::ios::binary);
  out << content;
  if (!out.flush()) throw ConfigError(file.string() + ": cannot be written");
}

void refuse(const Path& file, std::size_t line, const std::string& rule) {
  throw ConfigError(file.string() + ":" + std::to_string(line) + ":1: " + rule);
}

}  // namespace armsight::tools
