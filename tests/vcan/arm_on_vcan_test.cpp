// Only here: both ends of the bus through the kernel's AF_CAN, as on a real arm: filters, own echo of SYNC, error
// frames, an interface that is not there.
#include <csignal>

#include "tests/system/system_rig.hpp"
#include "tests/vcan/vcan_rig.hpp"

namespace armsight::demo {
namespace {

class ArmOnVcan : public SystemTest {
 protected:
  void SetUp() override {
    ARMSIGHT_NEEDS_VCAN();
    DemoOptions options = quiet_robot();
    options.pace = "real";
    options.can_interface = "vcan0";
    options.robot_file = vcan::guest_robot(options.home, robot_file("guest.yaml"));
    start(options);
  }

  std::string line_of(const std::string& start) {
    for (const std::string& line : arm().host_lines())
      if (line.starts_with(start)) return line;
    return {};
  }
};

TEST_F(ArmOnVcan, MovesTellsItsStateAndStops) {
  EXPECT_NE(arm().bus_line().find("SocketCAN"), std::string::npos) << arm().bus_line();
  ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
  ASSERT_EQ(arm().host({"status"}), 0);
  EXPECT_NE(line_of("controller:").find("socketcan vcan0"), std::string::npos) << line_of("controller:");
  EXPECT_NE(line_of("joints:").find("25.2 8.0 -14.9 78.5 -45.8 deg read"), std::string::npos) << line_of("joints:");
  conductor().start("host", arm().host_command({"move", "--joints=-1.36,0.57,-1.35,0.67,-0.16", "--speed", "0.1"}));
  conductor().run_cycles(400);  // of 36 s on the way
  EXPECT_EQ(arm().host({"stop"}), 0);
  EXPECT_EQ(conductor().end("host"), 1) << "a move that was stopped did not arrive";
  ASSERT_EQ(arm().host({"status"}), 0);
  EXPECT_NE(line_of("mode:").find("hold"), std::string::npos) << line_of("mode:") << "; " << line_of("fault:");
}

}  // namespace
}  // namespace armsight::demo
