// The example client in Python, written from protocol/README.md alone: how long it is, and that it does what it says.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/bench/bench_row.hpp"
#include "tests/system/quiet_arm.hpp"

namespace armsight::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kClient = ARMSIGHT_HOME "/protocol/examples/arm_client.py";

Row client_row() {
  Row row{"Python client: says hello, takes the lease, sends a goal, stops", "lines", 0.0, {}, "", "at most 100 lines",
          false, {}};
  std::ifstream in(kClient);
  for (std::string line; std::getline(in, line);) row.ours += 1.0;
  const TemporaryFolder folder;
  output_of("protoc -I '" ARMSIGHT_HOME "' --python_out='" + folder.path().string() + "' protocol/arm_link.proto");
  demo::DemoOptions options = demo::quiet_robot();
  options.pace = "real";
  demo::write_patient_robot(options.robot_file, folder.path() / "patient.yaml");
  options.robot_file = folder.path() / "patient.yaml";
  demo::RunningArm arm(options, folder.path() / "run", false);
  if (arm.host({"enable"}) != 0) return row.why = "the arm did not come up", row;
  std::vector<std::string> lines;
  const int code = arm.conductor().run("client",
                                       {"/usr/bin/env", "PYTHONPATH=" + folder.path().string(), "/usr/bin/python3",
                                        kClient, arm.link(), "0.1"},
                                       &lines);
  row.why = lines.empty() ? "it said nothing" : lines.back();
  row.holds = code == 0 && row.ours <= 100.0 && row.why.starts_with("stopped after");
  return row;
}

}  // namespace

std::vector<Row> client_rows(bool /*is_quick*/) { return {client_row()}; }

}  // namespace armsight::bench
