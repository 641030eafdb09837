// Only here: both ends of the bus through the kernel's AF_CAN, as on a real arm: filters, own echo of SYNC, error
// frames, an interface that is not there.
#include <csignal>

#include "tests/system/mixed_robot.hpp"
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
    options.can_interfaces = {"vcan0"};
    options.robot_file = vcan::guest_robot(options.home, robot_file("guest.yaml"));
    adapt(options);
    start(options);
  }
  virtual void adapt(DemoOptions&) const {}

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

/// Shoulder on vcan0, CANopen; elbow and forearm on vcan1, DAMIAO in CAN FD.
class TwoBusesOnVcan : public ArmOnVcan {
 protected:
  void adapt(DemoOptions& options) const override {
    options.can_interfaces.push_back("vcan1");
    make_damiao(options.robot_file, {4, 5});
  }
};

TEST_F(TwoBusesOnVcan, MoveBothFamiliesOneInCanFd) {
  ASSERT_EQ(arm().host({"move", "--joints=0.3,-0.3,-0.2,1.2,0.4"}), 0);
  ASSERT_EQ(arm().host({"status"}), 0);
  EXPECT_NE(line_of("controller:").find("socketcan vcan0+vcan1"), std::string::npos) << line_of("controller:");
  EXPECT_NE(line_of("joints:").find("17.2 -17.2 -11.5 68.8 22.9 deg read"), std::string::npos) << line_of("joints:");
  const BusShares shares = count_frames(read_bus_log(folder_), "vcan0");
  EXPECT_GT(shares.classic_on_first, 100);
  EXPECT_GT(shares.fd_on_second, 100);
  EXPECT_EQ(shares.fd_on_first, 0);
  EXPECT_EQ(shares.classic_on_second, 0);
}

}  // namespace
}  // namespace armsight::demo
