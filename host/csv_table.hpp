// A CSV file with a header, read strictly: same number of fields in every row, names once, numbers that are numbers.
// Every violation is collected as "file:line:column: name = value: rule" (column counts characters, from 1).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace armsight::host {

class CsvTable {
 public:
  /// Reads the file; throws ConfigError where it cannot be read or has no header.
  explicit CsvTable(const std::filesystem::path& file);

  std::size_t rows() const { return rows_.size(); }
  /// Index of a column; nullopt where the header has none.
  std::optional<std::size_t> column(const std::string& name) const;
  const std::vector<std::string>& header() const { return header_; }

  /// The finite number there; records a violation and answers 0 otherwise.
  double number(std::size_t row, std::size_t column);
  const std::string& text(std::size_t row, std::size_t column) const;
  bool is_empty(std::size_t row, std::size_t column) const { return text(row, column).empty(); }

  std::string place(std::size_t row) const;  ///< "samples.csv:12"
  void refuse(std::size_t row, std::size_t column, const std::string& rule);
  void refuse_header(const std::string& name, const std::string& rule);
  /// Throws ConfigError with all violations, if the header has any: then the rows mean nothing.
  void finish_header() const;
  /// Throws ConfigError with all violations, if any.
  void finish() const;

 private:
  struct Row {
    std::size_t line = 0;
    std::vector<std::string> fields;
    std::vector<std::size_t> at;  // first character of each field, from 1
  };
  Row split(const std::string& line, std::size_t number) const;

  std::string file_;
  std::vector<std::string> header_;
  std::vector<std::size_t> header_at_;
  std::vector<Row> rows_;
  std::vector<std::string> violations_;
  bool has_header_violation_ = false;
};

}  // namespace armsight::host
