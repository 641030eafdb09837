// The shipped program as a file and as a process: how large it is, what it needs, how much memory it holds while it
// keeps an arm that arm_sim simulates.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/bench/bench_row.hpp"
#include "tests/system/quiet_arm.hpp"

namespace armsight::bench {
namespace {

namespace fs = std::filesystem;

fs::path programs() { return demo::quiet_robot().programs; }

Row size_row() {
  const TemporaryFolder folder;
  const fs::path stripped = folder.path() / "arm_controller";
  output_of("strip -o '" + stripped.string() + "' '" + (programs() / "arm_controller").string() + "'");
  std::error_code error;
  const auto bytes = fs::file_size(stripped, error);
  Row row{"binary (stripped, release) of arm_controller", "MB", 0.0, {}, "", "at most 2.5 MB", false, {}};
  if (error) return row.why = "strip (binutils) did not run", row;
  row.ours = 1e-6 * static_cast<double>(bytes);
  row.holds = row.ours <= 2.5;
  return row;
}

Row libraries_row() {
  Row row{"needed libraries of arm_controller beside libc and libm", "", 0.0, {}, "",
          "at most libssl, libcrypto, libc, libm", true, {}};
  std::istringstream lines(output_of("objdump -p '" + (programs() / "arm_controller").string() + "' | grep NEEDED"));
  std::string word, library;
  int count = 0;
  while (lines >> word >> library) {
    ++count;
    row.why += (row.why.empty() ? "" : ", ") + library;
    const bool is_system =
        library.starts_with("libc.") || library.starts_with("libm.") || library.starts_with("ld-linux");
    if (is_system) continue;
    row.ours += 1.0;
    if (!library.starts_with("libssl.") && !library.starts_with("libcrypto.")) row.holds = false;
  }
  if (count == 0) row.holds = false, row.why = "objdump (binutils) did not run";
  return row;
}

double status_kB(pid_t pid, const std::string& key) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/status");
  std::string line;
  while (std::getline(in, line))
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1));
  return 0.0;
}

Row resident_row() {
  Row row{"resident with memory locked, arm_controller at real pace", "MB", 0.0, {}, "", "at most 16 MB", false, {}};
  const TemporaryFolder folder;
  demo::DemoOptions options = demo::quiet_robot();
  options.pace = "real";
  demo::RunningArm arm(options, folder.path() / "run", false);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const pid_t pid = arm.conductor().find("arm_controller")->pid();
  row.ours = 1e-3 * status_kB(pid, "VmRSS");
  const double locked = 1e-3 * status_kB(pid, "VmLck");
  row.holds = row.ours > 0.0 && row.ours <= 16.0 && locked > 0.0;
  if (locked == 0.0) row.why = "not run: memory could not be locked here (no right)";
  return row;
}

}  // namespace

std::vector<Row> program_rows(bool /*is_quick*/) { return {size_row(), libraries_row(), resident_row()}; }

}  // namespace armsight::bench
