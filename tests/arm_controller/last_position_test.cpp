// Where the joints were last seen: kept to a nanoradian, and what is wrong with a file is said, never guessed.
#include "arm_controller/last_position.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/arm_controller/arm_rig.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight::arm::test {
namespace {

class LastPositionFile : public ::testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(folder_.path() / "position.txt") << text; }
  LastPosition load() const { return load_last_position(folder_.path(), robot_); }

  TemporaryFolder folder_;
  RobotConfig robot_ = nominal_robot();
};

TEST_F(LastPositionFile, ComesBack) {
  JointVector q(5);
  q << 0.1, -1.234567891, 2.0, 0.0, -0.5;
  save_last_position(folder_.path(), robot_, q);
  const LastPosition last = load();
  ASSERT_TRUE(last.q_reading_rad) << last.why;
  EXPECT_LT((*last.q_reading_rad - q).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_TRUE(last.why.empty());
}

TEST_F(LastPositionFile, AbsentIsNothingToSpeakOf) {
  EXPECT_FALSE(load().q_reading_rad);
  EXPECT_TRUE(load().why.empty());
}

TEST_F(LastPositionFile, DamagedOrForeignIsNamed) {
  const std::string hash = std::to_string(model_hash(robot_));
  const struct {
    std::string text, why;
  } files[] = {{"", "must begin with"},
               {"garbage\n", "must begin with"},
               {"armsight-position-1 " + hash + " 0 0 0", "5 angles"},
               {"armsight-position-1 " + hash + " 0 0 nan 0 0", "5 angles"},
               {"armsight-position-1 1234 0 0 0 0 0", "another robot's"}};
  for (const auto& [text, why] : files) {
    write(text);
    EXPECT_FALSE(load().q_reading_rad) << text;
    EXPECT_NE(load().why.find(why), std::string::npos) << text << ": " << load().why;
    EXPECT_NE(load().why.find("position.txt"), std::string::npos) << load().why;
  }
}

}  // namespace
}  // namespace armsight::arm::test
