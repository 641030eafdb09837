// Learn on other people's data beside what their authors and peers get: one row a figure, with its bar. Every figure
// of held-out looks is the median over the fold seeds; everything is made inside the training part
// (host/nested_validation).
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace armsight::tools {

struct ProofRow {
  std::string dataset, figure, unit;
  std::optional<double> ours, peer;
  std::string peer_name;
  std::optional<double> bar;       ///< none: told, not judged
  bool is_least = false;           ///< the bar is what must be reached, not what must not be passed
  bool is_exact = false;           ///< the bar is the one right answer
  std::string why;                 ///< could not run: the reason
  bool holds() const;
};

struct ProofOptions {
  std::filesystem::path data;      ///< the hand-out's folder, one folder a set
  int fold_seeds = 10;
};

/// Names of the five sets.
std::vector<std::string> proof_sets();
/// The rows of one set; one that could not be run gives one row with `why`. `told`: progress in words.
std::vector<ProofRow> prove_set(const std::string& set, const ProofOptions& options, std::ostream& told);

std::string proof_json(const std::vector<ProofRow>& rows);
/// A table for people; `markdown` for a README.
std::string proof_table(const std::vector<ProofRow>& rows, bool markdown);

}  // namespace armsight::tools
