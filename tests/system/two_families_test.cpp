// Only here: the real programs with an arm on two buses, elbow and forearm DAMIAO drives on the second, in CAN FD.
// Judged by the simulator's truth and its log of both buses.
#include "tests/system/mixed_robot.hpp"
#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class TwoFamilies : public SystemTest {
 protected:
  std::filesystem::path mixed_robot() const {
    const std::filesystem::path file = robot_file("mixed.yaml");
    std::filesystem::copy_file(quiet_robot().robot_file, file);
    make_damiao(file, {4, 5});
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

  const BusShares shares = count_frames(read_bus_log(folder_), "emulated");
  EXPECT_GT(shares.classic_on_first, 1000);
  EXPECT_GT(shares.fd_on_second, 1000);
  EXPECT_EQ(shares.fd_on_first, 0);
  EXPECT_EQ(shares.classic_on_second, 0) << "no SYNC and no heartbeat where nobody listens to one";
}

}  // namespace
}  // namespace armsight::demo
