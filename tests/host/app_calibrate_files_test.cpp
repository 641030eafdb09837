// What Learn leaves on disk is what Learn was given: nothing of the last run goes before there is something new, and
// the saved looks solve to the same model.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "host/calibrate_files.hpp"
#include "host/learn_dataset.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace armsight::host {
namespace {

constexpr double kEncoderSigma_rad = 0.00175;

std::vector<LookSample> seen_looks(int count) {
  std::mt19937 random(11);
  const test::TrueRobot robot = test::true_robot(random);
  std::vector<LookSample> looks;
  for (int k = 0; k < count; ++k) {
    const JointVector q_real = test::random_visible_posture(robot, random);
    const HandPoseMeasurement z = test::look_at(robot, q_real, {0.2, kEncoderSigma_rad}, k == 3, random);
    LookSample look{z.q, z.T_C_H, z.T_C_H_second, z.R_vision, 1'000'000'000 + k, {}};
    if (k % 4 == 1) look.T_C_H_second.reset();
    looks.push_back(look);
  }
  return looks;
}

CalibrationOptions options_of(const RobotConfig& robot) {
  CalibrationOptions options;
  options.encoder_sigma_rad = robot.filter.encoder_sigma_rad;
  options.floor_position_sigma_m = robot.filter.floor_position_sigma_m;
  options.floor_rotation_sigma_rad = robot.filter.floor_rotation_sigma_rad;
  options.joint_names = robot.joint_names;
  return options;
}

class LookFilesTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("armsight-looks-" + std::to_string(getpid()));
  std::filesystem::path looks_ = folder_ / "looks";
  RobotConfig robot_ = load_robot(ARMSIGHT_ROBOT_YAML);
};

TEST_F(LookFilesTest, SolveToTheVeryModelOfTheLiveRun) {
  const std::vector<LookSample> looks = seen_looks(14);
  LookFiles files(looks_, robot_, ARMSIGHT_ROBOT_YAML);
  for (const LookSample& look : looks) files.add(look);
  const ArmCalibration live = calibrate_arm(robot_.arm, looks, options_of(robot_));
  ASSERT_TRUE(live.accepted) << live.why;

  const Dataset dataset = load_dataset(looks_);
  ASSERT_EQ(dataset.observations.size(), looks.size());
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const Observation& z = dataset.observations[i];
    EXPECT_EQ(z.T_C_M.R, looks[i].T_C_H.R);
    EXPECT_EQ(z.T_C_M.p, looks[i].T_C_H.p);
    EXPECT_EQ(z.T_C_M_second.has_value(), looks[i].T_C_H_second.has_value());
    EXPECT_EQ(z.R_vision, Matrix6(looks[i].R_vision.selfadjointView<Eigen::Upper>()));
  }
  const ChainModel again = calibrate_dataset(dataset, {}).solution.model;
  EXPECT_EQ(again.T_C_a.value.p, live.model.T_C_B.p);
  EXPECT_EQ(again.T_C_a.value.R, live.model.T_C_B.R);
  for (int j = 0; j < 5; ++j)
    EXPECT_EQ(again.offsets[static_cast<std::size_t>(j)].value, live.model.beta[j]) << "joint " << j + 1;
  EXPECT_GT(live.model.beta.cwiseAbs().maxCoeff(), 0.01) << "no offset was there to find";
}

TEST_F(LookFilesTest, TheLastRunsLooksStayUntilTheFirstNewOneIsOnDisk) {
  const std::vector<LookSample> looks = seen_looks(3);
  {
    LookFiles last(looks_, robot_, ARMSIGHT_ROBOT_YAML);
    for (const LookSample& look : looks) last.add(look);
  }
  LookFiles files(looks_, robot_, ARMSIGHT_ROBOT_YAML);
  EXPECT_EQ(load_dataset(looks_).rows, 3) << "emptied before there was a new look";
  files.add(looks[0]);
  EXPECT_EQ(load_dataset(looks_).rows, 1);
  EXPECT_EQ(load_dataset(looks_.string() + "-previous").rows, 3);
  files.add(looks[1]);
  EXPECT_EQ(load_dataset(looks_).rows, 2);
  EXPECT_EQ(load_dataset(looks_.string() + "-previous").rows, 3);
}

TEST_F(LookFilesTest, ALookThatCannotBeKeptIsAFailureNotABadFlag) {
  std::ofstream(folder_ / "file") << "no folder\n";
  LookFiles files(folder_ / "file/looks", robot_, ARMSIGHT_ROBOT_YAML);
  const LookSample look = seen_looks(1).front();
  try {
    files.add(look);
    FAIL() << "kept where nothing can be kept";
  } catch (const ConfigError& error) {
    FAIL() << "exit code 2 after the arm has moved: " << error.what();
  } catch (const std::exception&) {
  }
}

}  // namespace
}  // namespace armsight::host
