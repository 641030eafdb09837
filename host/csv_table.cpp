#include "host/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "protocol/strict_yaml.hpp"

namespace armsight::host {

CsvTable::CsvTable(const std::filesystem::path& file) : file_(file.string()) {
  const std::string content = read_text_file(file);
  std::size_t line_number = 0;
  for (std::size_t from = 0; from < content.size();) {
    std::size_t to = std::min(content.find('\n', from), content.size());
    std::string line = content.substr(from, to - from);
    from = to + 1;
    ++line_number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    Row row = split(line, line_number);
    if (header_.empty()) {
      header_ = row.fields;
      header_at_ = row.at;
    } else if (row.fields.size() != header_.size()) {
      violations_.push_back(file_ + ":" + std::to_string(line_number) + ":1: " + std::to_string(row.fields.size()) +
                            " fields: must be " + std::to_string(header_.size()) + ", as in the header");
    } else {
      rows_.push_back(std::move(row));
    }
  }
  if (header_.empty()) throw ConfigError(file_ + ": has no header line");
  for (std::size_t i = 0; i < header_.size(); ++i) {
    if (std::find(header_.begin(), header_.begin() + static_cast<std::ptrdiff_t>(i), header_[i]) !=
        header_.begin() + static_cast<std::ptrdiff_t>(i)) {
      refuse_header(header_[i], "column name is already taken");
    }
  }
}

CsvTable::Row CsvTable::split(const std::string& line, std::size_t number) const {
  Row row;
  row.line = number;
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t to = std::min(line.find(',', from), line.size());
    std::size_t first = from, last = to;
    while (first < last && (line[first] == ' ' || line[first] == '\t')) ++first;
    while (last > first && (line[last - 1] == ' ' || line[last - 1] == '\t')) --last;
    row.fields.push_back(line.substr(first, last - first));
    row.at.push_back(first + 1);
    from = to + 1;
  }
  return row;
}

std::optional<std::size_t> CsvTable::column(const std::string& name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

double CsvTable::number(std::size_t row, std::size_t column) {
  const std::string& field = text(row, column);
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(value)) {
    refuse(row, column, "must be a finite number");
    return 0.0;
  }
  return value;
}

const std::string& CsvTable::text(std::size_t row, std::size_t column) const { return rows_[row].fields[column]; }

std::string CsvTable::place(std::size_t row) const {
  return std::filesystem::path(file_).filename().string() + ":" + std::to_string(rows_[row].line);
}

void CsvTable::refuse(std::size_t row, std::size_t column, const std::string& rule) {
  violations_.push_back(file_ + ":" + std::to_string(rows_[row].line) + ":" + std::to_string(rows_[row].at[column]) +
                        ": " + header_[column] + " = " + text(row, column) + ": " + rule);
}

void CsvTable::refuse_header(const std::string& name, const std::string& rule) {
  has_header_violation_ = true;
  const auto at = column(name);
  violations_.push_back(file_ + ":1:" + std::to_string(at ? header_at_[*at] : 1) + ": " + name + ": " + rule);
}

void CsvTable::finish_header() const {
  if (has_header_violation_) finish();
}

void CsvTable::finish() const {
  if (violations_.empty()) return;
  std::string text;
  constexpr std::size_t kMost = 50;
  for (std::size_t i = 0; i < std::min(violations_.size(), kMost); ++i) text += (i ? "\n" : "") + violations_[i];
  if (violations_.size() > kMost) text += "\n… and " + std::to_string(violations_.size() - kMost) + " more";
  throw ConfigError(text);
}

}  // namespace armsight::host
