// The simulated arm with its real controller and host, for tests that do something to them meanwhile.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "tests/system/quiet_arm.hpp"

namespace armsight::demo {

class SystemTest : public testing::Test {
 protected:
  void start(const DemoOptions& options) { arm_ = std::make_unique<RunningArm>(options, folder_, false); }
  RunningArm& arm() { return *arm_; }
  Conductor& conductor() { return arm_->conductor(); }

  void start_moving() { ASSERT_TRUE(start_slow_move(arm())); }

  /// EMCY of the arm's nodes on the bus so far.
  int emergencies() const {
    return static_cast<int>(std::ranges::count_if(read_bus_log(folder_), [](const CandumpLine& line) {
      return is_emergency(line.frame);
    }));
  }

  void TearDown() override {
    arm_.reset();
    if (HasFailure()) std::printf("left for inspection: %s*\n", folder_.c_str());
    for (const std::filesystem::path& path : {folder_, robot_file("")})
      if (!HasFailure()) std::filesystem::remove_all(path);
  }

  /// Where a test keeps robot files of its own: the run empties its own folder when it begins.
  std::filesystem::path robot_file(const std::string& name) const {
    const std::filesystem::path robots = folder_.string() + "-robots";
    if (!name.empty()) std::filesystem::create_directories(robots);
    return name.empty() ? robots : robots / name;
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      ("armsight-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()).substr(0, 24) + "-" +
       std::to_string(getpid()));
  std::unique_ptr<RunningArm> arm_;
};

}  // namespace armsight::demo
