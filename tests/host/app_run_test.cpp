// What the program answers before it has connected to anything: port 1 of this machine has no controller, so a bad line
// that got as far as connecting would answer 3 instead of 2.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

#include "host/command_line.hpp"

namespace armsight::host {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Run : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  CommandLine move_line() const {
    CommandLine line;
    line.verb = Verb::kMove;
    line.arm = "127.0.0.1:1";
    line.state = folder_ / "state";
    line.robot = ARMSIGHT_ROBOT_YAML;
    line.joints_rad = {0.1, 0.1, 0.1, 1.0, 0.1};
    return line;
  }
  CommandLine pose_line() const {
    CommandLine line = move_line();
    line.joints_rad.clear();
    line.pose = {0.0, -0.2, -0.1, 1.0, 0.0, 0.0, 0.0};
    return line;
  }
  /// Exit code; what was said on stderr stands in said_.
  int run_line(const CommandLine& line) {
    testing::internal::CaptureStderr();
    const int code = run(line);
    said_ = testing::internal::GetCapturedStderr();
    return code;
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("armsight-run-" + std::to_string(getpid()));
  std::string said_;
};

TEST_F(Run, ASoundLineGetsAsFarAsTheMissingController) {
  EXPECT_EQ(run_line(move_line()), 3) << said_;
  EXPECT_EQ(run_line(pose_line()), 3) << said_;
}

TEST_F(Run, NumbersThatAreNoneAreRefusedBeforeConnecting) {
  for (const double nonsense : {kNan, kInfinity, -kInfinity}) {
    for (std::size_t k = 0; k < 7; ++k) {
      CommandLine line = pose_line();
      line.pose[k] = nonsense;
      EXPECT_EQ(run_line(line), 2) << "value " << k << ": " << said_;
      EXPECT_NE(said_.find("--pose"), std::string::npos) << said_;
    }
    CommandLine line = move_line();
    line.joints_rad[3] = nonsense;
    EXPECT_EQ(run_line(line), 2) << said_;
    EXPECT_NE(said_.find("--joints"), std::string::npos) << said_;
  }
  CommandLine line = move_line();
  line.speed = kNan;
  EXPECT_EQ(run_line(line), 2) << said_;
  EXPECT_NE(said_.find("--speed"), std::string::npos) << said_;
}

TEST_F(Run, ANamedPostureIsOneOfTheRobotFiles) {
  CommandLine line = move_line();
  line.joints_rad.clear();
  line.posture = "ready";
  EXPECT_EQ(run_line(line), 3) << said_;
  line.posture = "bed";
  EXPECT_EQ(run_line(line), 2) << said_;
  EXPECT_NE(said_.find("park, ready"), std::string::npos) << said_;
  line.posture.clear();
  EXPECT_EQ(run_line(line), 2) << "move must say where to";
  line.verb = Verb::kPark;
  EXPECT_EQ(run_line(line), 3) << "park knows where: " << said_;
}

TEST_F(Run, AnAddressThatIsNoneIsABadFlagNotALostPeer) {
  for (const char* address : {"nowhere", "127.0.0.1:70000", "127.0.0.1:"}) {
    CommandLine line = move_line();
    line.arm = address;
    EXPECT_EQ(run_line(line), 2) << address << ": " << said_;
  }
}

TEST_F(Run, ACameraThatIsNotThereIsALostPeer) {
  CommandLine line = move_line();
  line.verb = Verb::kAdapt;
  line.camera = "sim:127.0.0.1:1";
  EXPECT_EQ(run_line(line), 3) << said_;
  line.camera = "sim:nowhere";
  EXPECT_EQ(run_line(line), 2) << said_;
}

TEST_F(Run, AStateFolderThatCannotBeWrittenIsRefusedBeforeConnecting) {
  std::ofstream(folder_ / "file") << "no folder\n";
  CommandLine line = move_line();
  line.state = folder_ / "file";
  EXPECT_EQ(run_line(line), 2) << said_;
  EXPECT_NE(said_.find("--state"), std::string::npos) << said_;
  line.state = "/proc/armsight";
  EXPECT_EQ(run_line(line), 2) << said_;
  EXPECT_NE(said_.find("--state"), std::string::npos) << said_;
}

TEST_F(Run, ALineThatFailsKeepsTheLastRunsPictures) {
  const CommandLine line = move_line();
  std::filesystem::create_directories(folder_ / "state/images");
  std::ofstream(folder_ / "state/images/move-01.jpg") << "of the last run";
  EXPECT_EQ(run_line(line), 3);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "state/images/move-01.jpg"));
}

TEST_F(Run, AnOutputThatCannotBeWrittenIsOneLineAndExitCode2) {
  CommandLine line;
  line.verb = Verb::kPrintMarker;
  line.robot = ARMSIGHT_ROBOT_YAML;
  line.out = folder_ / "missing/marker.svg";
  EXPECT_EQ(run_line(line), 2) << said_;
  EXPECT_EQ(std::count(said_.begin(), said_.end(), '\n'), 1) << said_;
}

TEST_F(Run, ADataSetThatIsNoneIsRefused) {
  CommandLine line;
  line.verb = Verb::kCalibrate;
  for (const std::string& folder : {folder_.string() + "/missing", std::string(5000, 'x')}) {
    line.dataset = folder;
    EXPECT_EQ(run_line(line), 2) << said_;
  }
}

// A link to itself: asking whether it exists throws an exception of the library's own.
TEST_F(Run, WhatNobodyForesawIsOneLineAndExitCode1) {
  std::ofstream(folder_ / "dataset.yaml")
      << "dataset: looped\nchains:\n  - {name: arm, given: true}\ncamera: {on: root}\n"
         "targets:\n  - {name: tag, on: arm, kind: pose}\n";
  std::filesystem::create_symlink("arm.csv", folder_ / "arm.csv");
  CommandLine line;
  line.verb = Verb::kCalibrate;
  line.dataset = folder_;
  EXPECT_EQ(run_line(line), 1) << said_;
  EXPECT_TRUE(said_.starts_with("host: ")) << said_;
  EXPECT_EQ(std::count(said_.begin(), said_.end(), '\n'), 1) << said_;
}

}  // namespace
}  // namespace armsight::host
