// Only here: what a person asks `host move` for is what the simulated arm does, judged by the simulator's truth.
#include <algorithm>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class Move : public SystemTest {};

double fastest_rad_s(const Truth& truth, std::int64_t after_ns) {
  double fastest = 0.0;
  for (std::size_t row = 0; row + 1 < truth.rows.size(); ++row) {
    if (truth.rows[row].arm_time_ns > after_ns) fastest = std::max(fastest, speed_rad_s(truth, row));
  }
  return fastest;
}

TEST_F(Move, ToAPoseKeepsToTheSpeedAskedFor) {
  start(quiet_robot());
  ASSERT_EQ(arm().host({"move", "--joints=0.2,-0.2,-0.2,1.0,0.0"}), 0);
  const double begun_s = conductor().time_s();
  // The nominal hand pose at 0.9, 0.3, -0.8, 1.6, 0.6 rad: more than a radian away.
  ASSERT_EQ(arm().host({"move",
                        "--pose=0.028730568,-0.171056387,-0.174780504,0.764019853,0.524954480,-0.196979848,0.319210586",
                        "--speed", "0.1"}),
            0);
  const double took_s = conductor().time_s() - begun_s;
  const Truth truth = arm().finish();
  const std::int64_t begun_ns = truth.rows.back().arm_time_ns - static_cast<std::int64_t>(took_s * 1e9);
  const double fastest = fastest_rad_s(truth, begun_ns);
  EXPECT_GT(fastest, 0.15) << "the arm was not under way";
  EXPECT_LT(fastest, 0.25) << "a tenth of 2 rad/s was asked for";
}

TEST_F(Move, FolderInWhichARunWorksIsRefusedToAnother) {
  start(quiet_robot());
  EXPECT_THROW(RunningArm(quiet_robot(), folder_, false), ConfigError);
  EXPECT_EQ(arm().host({"status"}), 0) << "the first goes on";
}

}  // namespace
}  // namespace armsight::demo
