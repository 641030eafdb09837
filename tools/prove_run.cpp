// prove_run: Learn on the five public calibration sets, k-fold by look, beside the peers' figures. tools/prove builds
// and starts it. 0: every bar holds; 1: one is missed, or a set could not be run; 2: bad flag or folder.
#include <fstream>
#include <iostream>

#include "tools/command_line.hpp"
#include "tools/proof/proof.hpp"

int main(int argc, char** argv) {
  using namespace armsight::tools;
  CommandLine line("Learn on other people's calibration data, beside what they get; writes DIR/prove.json", "prove");
  std::string data, out, only;
  bool is_quick = false, is_markdown = false;
  line.add("--data", data, "folder with the public data sets, one folder each").required();
  line.add("--out", out, "folder for prove.json and prove.md").required();
  line.add("--only", only, "this set alone");
  line.add("--quick", is_quick, "one fold seed instead of ten");
  line.add("--markdown", is_markdown, "print the table as a README has it");
  if (const auto code = line.parse(argc, argv)) return *code;
  std::error_code error;
  if (!std::filesystem::is_directory(data, error)) {
    std::cerr << "prove: --data " << data << ": is not a folder\n";
    return 2;
  }
  std::filesystem::create_directories(out, error);
  ProofOptions options{data, is_quick ? 1 : 10};
  std::vector<ProofRow> rows;
  for (const auto& set : proof_sets()) {
    if (!only.empty() && set != only) continue;
    const auto of_set = prove_set(set, options, std::cout);
    rows.insert(rows.end(), of_set.begin(), of_set.end());
  }
  std::ofstream json(std::filesystem::path(out) / "prove.json"), markdown(std::filesystem::path(out) / "prove.md");
  json << proof_json(rows);
  markdown << proof_table(rows, true);
  if (!json.flush() || !markdown.flush()) {
    std::cerr << "prove: --out " << out << ": cannot be written\n";
    return 2;
  }
  std::cout << '\n' << proof_table(rows, is_markdown);
  for (const auto& row : rows) {
    if (!row.holds()) return 1;
  }
  return rows.empty() ? 2 : 0;
}
