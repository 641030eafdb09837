// Prints the benchmark rows as a table and, asked for, writes them as JSON: what tools/bench starts.
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/bench/bench_row.hpp"

namespace {

using armsight::bench::Row;

void print(const Row& row) {
  std::printf("%-66s %10.3g %-3s", row.name.c_str(), row.ours, row.unit.c_str());
  if (row.peer) std::printf(" | %s %.3g, ratio %.1f", row.peer_name.c_str(), *row.peer, *row.peer / row.ours);
  if (row.holds) std::printf(" | %s: %s", row.bar.c_str(), *row.holds ? "holds" : "MISSED");
  std::printf("\n");
  if (!row.why.empty()) std::printf("    %s\n", row.why.c_str());
}

nlohmann::json to_json(const Row& row) {
  nlohmann::json j{{"name", row.name},     {"unit", row.unit}, {"ours", row.ours}, {"peer", nullptr},
                   {"peer_name", nullptr}, {"ratio", nullptr}, {"bar", nullptr},   {"holds", row.holds.value_or(true)}};
  if (row.peer) {
    j["peer"] = *row.peer;
    j["peer_name"] = row.peer_name;
    j["ratio"] = *row.peer / row.ours;
  }
  if (row.holds) j["bar"] = row.bar;
  if (!row.why.empty()) j["why"] = row.why;
  return j;
}

}  // namespace

/// bench_rows [--quick] [--json FILE]: 0 all bars hold (or --quick), 1 one is missed, 2 bad arguments.
int main(int argc, char** argv) {
  bool is_quick = false;
  std::string file;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0)
      is_quick = true;
    else if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      file = argv[++i];
    else
      return std::fprintf(stderr, "bench_rows: unknown argument '%s'\n", argv[i]), 2;
  }
  bool all_hold = true;
  nlohmann::json list = nlohmann::json::array();
  for (const auto& rows : {armsight::bench::kinematics_rows, armsight::bench::controller_rows,
                           armsight::bench::wake_up_rows, armsight::bench::stop_rows, armsight::bench::program_rows,
                           armsight::bench::client_rows}) {
    for (const Row& row : rows(is_quick)) {
      print(row);
      std::fflush(stdout);
      all_hold = all_hold && row.holds.value_or(true);
      list.push_back(to_json(row));
    }
  }
  if (!file.empty()) {
    std::ofstream out(file);
    out << list.dump(1) << '\n';
    if (!out.flush()) return std::fprintf(stderr, "bench_rows: cannot write %s\n", file.c_str()), 2;
  }
  return all_hold || is_quick ? 0 : 1;
}
