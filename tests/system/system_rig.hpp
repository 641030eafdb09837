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
    if (!HasFailure()) std::filesystem::remove_all(folder_);
    else std::printf("left for inspection: %s\n", folder_.c_str());
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("armsight-system-" + std::to_string(getpid()));
  std::unique_ptr<RunningArm> arm_;
};

}  // namespace armsight::demo
