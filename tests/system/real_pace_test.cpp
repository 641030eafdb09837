// Only here: link, camera, goals, stop and recording all active on the machine's own clock; what TSan watches.
#include <csignal>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class RealPace : public SystemTest {
 protected:
  RealPace() {
    DemoOptions options = quiet_robot();
    options.pace = "real";
    start(options);
  }
};

TEST_F(RealPace, MovesLooksStopsAndRecords) {
  ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
  conductor().start("host", arm().host_command({"move", "--joints=1.16,0.57,-1.35,0.67,-0.16", "--speed", "0.1"}));
  conductor().run_cycles(400);
  EXPECT_EQ(arm().host({"stop"}), 0) << "stop is taken from anybody";
  conductor().end("host");
  EXPECT_EQ(arm().host({"status"}), 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "controller/ticks.mcap"));
}

TEST_F(RealPace, StoppedHostLosesItsLease) {
  ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
  conductor().start("host", arm().host_command({"move", "--joints=1.16,0.57,-1.35,0.67,-0.16", "--speed", "0.1"}));
  conductor().run_cycles(400);
  conductor().find("host")->send_signal(SIGSTOP);  // the connection stays open
  conductor().run_cycles(250);
  ASSERT_EQ(arm().host({"status"}), 0);
  bool is_holding = false;
  for (const std::string& line : arm().host_lines()) is_holding |= line.starts_with("mode:") && line.find("HOLD") != std::string::npos;
  EXPECT_TRUE(is_holding);
  conductor().kill("host");
}

}  // namespace
}  // namespace armsight::demo
