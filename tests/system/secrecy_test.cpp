// Only here: host and controller open neither the scene nor the truth nor the experiment's poses (seen by strace).
#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

bool can_trace() {
  ChildProcess probe("strace", {"/usr/bin/strace", "-f", "--seccomp-bpf", "-o", "/dev/null", "/bin/true"});
  while (!probe.exit_code()) usleep(1000);
  return *probe.exit_code() == 0;
}

std::vector<std::string> lines_of(const std::filesystem::path& trace) {
  std::vector<std::string> lines;
  std::ifstream in(trace);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class Secrecy : public SystemTest {
 protected:
  void start_traced(const std::filesystem::path& traces) {
    std::filesystem::create_directories(traces);
    DemoOptions options = quiet_robot();
    for (const char* program : {"arm_controller", "host"}) {
      options.tracers[program] = {"/usr/bin/strace", "-f", "--seccomp-bpf", "-A", "-e",
                                  "trace=open,openat,openat2,creat", "-o", (traces / program).string()};
    }
    start(options);
  }
  static void expect_no_secret(const std::string& program, const std::vector<std::string>& opened) {
    EXPECT_GT(opened.size(), 5U) << program << " was not traced";
    for (const std::string& line : opened) {
      for (const char* secret : {"tools/sim", "scene.yaml", "chapter8", "/sim/", "truth"})
        EXPECT_EQ(line.find(secret), std::string::npos) << program << " opens " << line;
    }
  }
};

TEST_F(Secrecy, HostAndControllerOpenNothingOfTheSimulatorInAnyPhase) {
  if (!can_trace()) {
    const char* required = std::getenv("ARMSIGHT_REQUIRE_STRACE");
    if (required && std::string(required) == "1") FAIL() << "strace cannot trace, and ARMSIGHT_REQUIRE_STRACE is set";
    GTEST_SKIP() << "strace cannot trace here";
  }
  const std::filesystem::path traces = folder_.string() + "-traces";
  start_traced(traces);
  ASSERT_EQ(arm().host({"calibrate", "--looks", "6"}), 0);
  ASSERT_EQ(arm().host({"adapt", "--looks", "3"}), 0);
  ASSERT_EQ(arm().host({"grasp", "--object", "can", "--grasps", ARMSIGHT_HOME "/host/config/grasps.yaml"}), 0);
  conductor().end("arm_controller");
  expect_no_secret("arm_controller", lines_of(traces / "arm_controller"));
  const std::vector<std::string> host = lines_of(traces / "host");
  expect_no_secret("host", host);
  for (const char* result : {"calibrate.json", "adapt.json", "grasp.json"}) {
    const auto names_it = [result](const std::string& line) { return line.find(result) != std::string::npos; };
    EXPECT_TRUE(std::ranges::any_of(host, names_it)) << "the trace lacks the verb that writes " << result;
  }
  std::filesystem::remove_all(traces);
}

}  // namespace
}  // namespace armsight::demo
