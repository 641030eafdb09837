// Only here: host and controller open neither the scene nor the truth nor the experiment's poses (seen by strace).
#include <fstream>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

bool can_trace() {
  ChildProcess probe("strace", {"/usr/bin/strace", "-o", "/dev/null", "/bin/true"});
  while (!probe.exit_code()) usleep(1000);
  return *probe.exit_code() == 0;
}

class Secrecy : public SystemTest {};

TEST_F(Secrecy, HostAndControllerOpenNothingOfTheSimulator) {
  if (!can_trace()) GTEST_SKIP() << "strace cannot trace here";
  const std::filesystem::path traces = folder_.string() + "-traces";
  std::filesystem::create_directories(traces);
  DemoOptions options = quiet_robot();
  for (const char* program : {"arm_controller", "host"}) {
    options.tracers[program] = {"/usr/bin/strace", "-f", "-e", "trace=open,openat,openat2,creat", "-o", (traces / program).string()};
  }
  start(options);
  ASSERT_EQ(arm().host({"calibrate", "--looks", "6"}), 0);
  conductor().end("arm_controller");
  for (const char* program : {"arm_controller", "host"}) {
    std::ifstream in(traces / program);
    int opened = 0;
    for (std::string line; std::getline(in, line); ++opened) {
      for (const char* secret : {"tools/sim", "scene.yaml", "chapter8", "/sim/", "truth"}) {
        EXPECT_EQ(line.find(secret), std::string::npos) << program << " opens " << line;
      }
    }
    EXPECT_GT(opened, 5) << program << " was not traced";
  }
  std::filesystem::remove_all(traces);
}

}  // namespace
}  // namespace armsight::demo
