// The simulated arm with its real controller and host, for tests that do something to them meanwhile.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tools/report/demo_session.hpp"

namespace armsight::demo {

/// The demo's robot without noise; programs stand beside the test.
inline DemoOptions quiet_robot() {
  DemoOptions options;
  options.home = ARMSIGHT_HOME;
  options.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  options.robot_file = options.home / "tools/experiments/demo_robot.yaml";
  options.noise = "clean";
  return options;
}

class SystemTest : public testing::Test {
 protected:
  void start(const DemoOptions& options) { arm_ = std::make_unique<RunningArm>(options, folder_, false); }
  RunningArm& arm() { return *arm_; }
  Conductor& conductor() { return arm_->conductor(); }

  /// A long, slow move (all joints about 1 rad at 0.6 rad/s) and two seconds of it: the host is in the middle.
  void start_moving() {
    ASSERT_EQ(arm().host({"move", "--joints=0.2,-0.2,-0.2,1.0,0.0"}), 0);
    conductor().start("host", arm().host_command({"move", "--joints=1.4,0.7,-1.3,2.2,1.2", "--speed", "0.3"}));
    conductor().run_cycles(500);
    ASSERT_NE(conductor().find("host"), nullptr);
    ASSERT_FALSE(conductor().find("host")->exit_code()) << "the move was over too soon";
  }

  /// EMCY of the arm's nodes on the bus so far: 081 to 086, code not zero.
  int emergencies() const {
    std::ifstream log(folder_ / "sim/bus.log");
    int count = 0;
    for (std::string line; std::getline(log, line);) {
      const auto at = line.find(" 08");
      const bool is_emergency = at != std::string::npos && line.size() > at + 9 && line[at + 3] >= '1' &&
                                line[at + 3] <= '6' && line.compare(at + 5, 4, "0000") != 0;
      count += is_emergency ? 1 : 0;
    }
    return count;
  }

  void TearDown() override {
    arm_.reset();
    if (!HasFailure()) std::filesystem::remove_all(folder_);
    else std::printf("left for inspection: %s\n", folder_.c_str());
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("armsight-system-" + std::to_string(getpid()));
  std::unique_ptr<RunningArm> arm_;
};

/// Largest joint speed between a row and the next.
inline double speed_rad_s(const Truth& truth, std::size_t row) {
  const TruthRow &a = truth.rows.at(row), &b = truth.rows.at(row + 1);
  return (b.q_true - a.q_true).cwiseAbs().maxCoeff() / (1e-9 * static_cast<double>(b.arm_time_ns - a.arm_time_ns));
}

}  // namespace armsight::demo
