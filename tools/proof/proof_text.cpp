// Rows of the proof as JSON for programs and as a table for people.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/proof/proof.hpp"

namespace armsight::tools {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kExactTolerance = 0.5;  // a count, or whole degrees

Json or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

std::string text_of(const std::optional<double>& value) {
  if (!value) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", *value);
  return text;
}

std::string bar_text(const ProofRow& row) {
  if (!row.bar) return "-";
  return (row.is_exact ? "" : row.is_least ? ">= " : "<= ") + text_of(row.bar);
}

std::vector<std::string> cells(const ProofRow& row) {
  const std::string peer = row.peer ? text_of(row.peer) + " (" + row.peer_name + ")" : row.peer_name;
  return {row.dataset,       row.figure, row.unit, row.why.empty() ? text_of(row.ours) : row.why,
          bar_text(row), row.holds() ? "yes" : "NO", peer.empty() ? "-" : peer};
}

}  // namespace

bool ProofRow::holds() const {
  if (!ours || !std::isfinite(*ours)) return false;
  if (!bar) return true;
  if (is_exact) return std::abs(*ours - *bar) <= kExactTolerance;
  return is_least ? *ours >= *bar : *ours <= *bar;
}

std::string proof_json(const std::vector<ProofRow>& rows) {
  Json list = Json::array();
  for (const auto& row : rows) {
    Json entry{{"dataset", row.dataset},      {"figure", row.figure},
               {"unit", row.unit},            {"ours", or_null(row.ours)},
               {"peer", or_null(row.peer)},   {"peer_name", row.peer_name},
               {"bar", or_null(row.bar)},     {"holds", row.holds()}};
    if (!row.why.empty()) entry["why"] = row.why;
    list.push_back(entry);
  }
  return list.dump(2) + "\n";
}

std::string proof_table(const std::vector<ProofRow>& rows, bool markdown) {
  std::vector<std::vector<std::string>> table{{"data set", "figure", "unit", "ours", "bar", "holds", "peer"}};
  for (const auto& row : rows) table.push_back(cells(row));
  std::vector<std::size_t> width(table[0].size(), 3);
  for (const auto& line : table) {
    for (std::size_t c = 0; c < line.size(); ++c) width[c] = std::max(width[c], line[c].size());
  }
  std::string text;
  for (std::size_t l = 0; l < table.size(); ++l) {
    for (std::size_t c = 0; c < table[l].size(); ++c) {
      text += (markdown ? "| " : c > 0 ? "  " : "") + table[l][c] + std::string(width[c] - table[l][c].size(), ' ');
      if (markdown) text += ' ';
    }
    text += markdown ? "|\n" : "\n";
    if (l > 0) continue;
    for (const std::size_t w : width) text += (markdown ? "|-" : "") + std::string(w, '-') + (markdown ? "-" : "  ");
    text += markdown ? "|\n" : "\n";
  }
  return text;
}

}  // namespace armsight::tools
