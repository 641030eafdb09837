// Only here: the real programs with an arm on two buses, elbow and forearm DAMIAO drives on the second, in CAN FD.
// Judged by the simulator's truth and its log of both buses.
#include <fstream>
#include <iterator>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class TwoFamilies : public SystemTest {
 protected:
  std::filesystem::path mixed_robot() const {
    std::ifstream in(quiet_robot().robot_file);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    for (const int node : {4, 5}) {
      const std::string id = std::to_string(node), old = "{node: " + id + ", counts_per_turn: 32768, sign: 1,";
      text.replace(text.find(old), old.size(),
                   "{family: damiao, node: " + id + ", reply_id: " + std::to_string(16 + node) +
                       ", bus: 1, fd: true,\n     position_range_rad: 12.5, speed_range_rad_s: 10, "
                       "torque_range_Nm: 28,\n     kp_Nm_rad: 80, kd_Nms_rad: 2, sign: 1,");
    }
    const std::filesystem::path file = robot_file("mixed.yaml");
    std::ofstream(file) << text;
    return file;
  }
};

TEST_F(TwoFamilies, AreMovedByTheHostOnTwoBuses) {
  DemoOptions options = quiet_robot();
  options.robot_file = mixed_robot();
  start(options);
  ASSERT_EQ(arm().host({"move", "--joints=0.3,-0.3,-0.2,1.2,0.4"}), 0);
  ASSERT_EQ(arm().host({"move", "--joints=-0.2,0.2,0.4,0.5,-0.4"}), 0);
  const Truth truth = arm().finish();
  const double goal[] = {-0.2, 0.2, 0.4, 0.5, -0.4};
  for (int j = 0; j < 5; ++j) EXPECT_NEAR(truth.rows.back().q_reading[j], goal[j], 0.004) << "joint " << j + 1;

  int on_first = 0, fd_on_first = 0, fd_on_second = 0, classic_on_second = 0;
  for (const CandumpLine& line : read_bus_log(folder_)) {
    const bool is_first = line.interface == "emulated";
    ASSERT_TRUE(is_first || line.interface == "emulated1") << line.interface;
    on_first += is_first && !line.frame.is_fd;
    fd_on_first += is_first && line.frame.is_fd;
    fd_on_second += !is_first && line.frame.is_fd;
    classic_on_second += !is_first && !line.frame.is_fd;
  }
  EXPECT_GT(on_first, 1000);
  EXPECT_GT(fd_on_second, 1000);
  EXPECT_EQ(fd_on_first, 0);
  EXPECT_EQ(classic_on_second, 0) << "no SYNC and no heartbeat where nobody listens to one";
}

}  // namespace
}  // namespace armsight::demo
