// What `host commission` makes of answers: the fit and what contradicts it, the robot file's text, terminal and file.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/host_io.hpp"
#include "host/joint_fit.hpp"
#include "host/operator.hpp"
#include "host/robot_file_edit.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

constexpr double kTolerance_rad = 0.2 * kDegree;

DriveConfig drive() {
  DriveConfig d;
  d.counts_per_turn = 32768;
  d.zero_rad = 0.1;
  return d;
}
/// A joint whose true angle is slope · reading + zero, seen at reading ± 2°.
JointReadings readings() { return {0.3, 0.3 + 2 * kDegree, 0.3 - 2 * kDegree}; }
JointAnswers answers(double slope, double zero) {
  const JointReadings r = readings();
  const auto at = [&](double reading) { return slope * reading + zero; };
  return {at(r.here_rad), at(r.up_rad), at(r.down_rad), slope > 0.0, -1.8, 1.8};
}
JointFit fit_of(const JointAnswers& a) {
  const auto fit = fit_joint(a, readings(), drive(), -1.5, 1.5, kTolerance_rad);
  EXPECT_TRUE(std::holds_alternative<JointFit>(fit)) << std::get<std::string>(fit);
  return std::holds_alternative<JointFit>(fit) ? std::get<JointFit>(fit) : JointFit{};
}
std::string refusal_of(const JointAnswers& a, double tolerance_rad = kTolerance_rad) {
  const auto fit = fit_joint(a, readings(), drive(), -1.5, 1.5, tolerance_rad);
  return std::holds_alternative<std::string>(fit) ? std::get<std::string>(fit) : "none";
}

TEST(JointFit, FindsSignAndZeroAndLeavesAScaleThatFits) {
  const JointFit fit = fit_of(answers(-1.0, 0.25));
  EXPECT_EQ(fit.sign, -1);
  EXPECT_EQ(fit.counts_per_turn, 32768);
  EXPECT_EQ(fit.gear, 1.0);
  EXPECT_NEAR(fit.zero_rad, 0.25 - 0.1, 1e-12);  // reading = turns + 0.1; true = -reading + 0.25
}

TEST(JointFit, FindsAGearThatTheDriveDoesNotKnow) {
  JointAnswers a = answers(0.5, 0.2);
  a.up_rad += 0.0003;  // the encoder's step
  const auto fit = std::get<JointFit>(fit_joint(a, readings(), drive(), -1.5, 1.5, 0.05 * kDegree));
  EXPECT_EQ(fit.counts_per_turn, 65536);
  EXPECT_EQ(fit.gear, 2.0);
  EXPECT_NEAR(fit.zero_rad, 0.5 * 0.1 + 0.2, 2e-4);
}

TEST(JointFit, NamesTheAnswerThatContradicts) {
  JointAnswers a = answers(1.0, 0.1);
  a.turned_positive = false;
  EXPECT_NE(refusal_of(a).find("said to have turned against its positive direction, but its angle went from"),
            std::string::npos)
      << refusal_of(a);
  a = answers(1.0, 0.1);
  a.here_rad += 0.6 * kDegree;
  EXPECT_NE(refusal_of(a).find("do not fit its encoder"), std::string::npos) << refusal_of(a);
  a = answers(1.0, 0.1);
  a.up_rad = a.down_rad = a.here_rad;
  EXPECT_NE(refusal_of(a).find("no more than they are exact"), std::string::npos) << refusal_of(a);
  EXPECT_NE(refusal_of(answers(0.5, 0.1)).find("measure its angles more exactly"), std::string::npos)
      << "0.2 deg are a fifth of the 2 deg that it turned";
  a = answers(1.0, 0.1);
  a.free_max_rad = 1.4;
  EXPECT_NE(refusal_of(a).find("it is free from"), std::string::npos) << refusal_of(a);
  EXPECT_NE(refusal_of(answers(1.0, 1.4)).find("beyond the limits"), std::string::npos);
}

TEST(JointFit, ADamiaoScaleIsItsRangesBusiness) {
  DriveConfig d = drive();
  d.family = DriveFamily::kDamiao;
  const auto fit = fit_joint(answers(0.5, 0.2), readings(), d, -1.5, 1.5, 0.05 * kDegree);
  ASSERT_TRUE(std::holds_alternative<std::string>(fit));
  EXPECT_NE(std::get<std::string>(fit).find("position_range_rad"), std::string::npos);
}

std::string shipped() { return read_text_file(ARMSIGHT_ROBOT_YAML); }
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}
constexpr const char* kElbow = "drive: {node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0, commissioned: true}}";

TEST(RobotFileEdit, ChangesNothingButTheDrive) {
  const std::string text =
      replaced(shipped(), kElbow, "drive: {node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0}}  # the new one");
  const std::string out = with_commissioned(text, "robot.yaml", {{3, {-1, 65536, 2.0, 0.125}}});
  EXPECT_EQ(out, replaced(shipped(), kElbow,
                          "drive: {node: 4, counts_per_turn: 65536, sign: -1, commissioned: true, "
                          "gear: 2, zero_rad: 0.125}}  # the new one"));
}

TEST(RobotFileEdit, KnowsBlocksToo) {
  const std::string text = replaced(
      shipped(),
      "  - {name: elbow_flexion,      dh: {a_m: 0, alpha_rad:  1.5707963267948966, d_m: 0,     theta_rad: 0},\n"
      "     min_rad: 0,     max_rad: 2.355, max_speed_rad_s: 0.5, max_acceleration_rad_s2: 4, max_jerk_rad_s3: 80,\n   "
      "  " +
          std::string(kElbow),
      "  - name: elbow_flexion\n    dh: {a_m: 0, alpha_rad: 1.57, d_m: 0, theta_rad: 0}\n    min_rad: 0\n    max_rad: "
      "2.355\n"
      "    max_speed_rad_s: 0.5\n    max_acceleration_rad_s2: 4\n    max_jerk_rad_s3: 80\n    drive:\n      node: 4\n"
      "      counts_per_turn: 32768\n      sign: 1        # to be seen\n      zero_rad: 0\n      commissioned: "
      "false\n");
  const std::string out = with_commissioned(text, "robot.yaml", {{3, {-1, 65536, 2.0, 0.125}}});
  EXPECT_NE(
      out.find(
          "      counts_per_turn: 65536\n      sign: -1        # to be seen\n      gear: 2\n      zero_rad: 0.125\n"
          "      commissioned: true\n"),
      std::string::npos)
      << out;
}

class Asked : public testing::Test {
 protected:
  Asked() { EXPECT_EQ(::pipe(ends_), 0); }
  ~Asked() override {
    ::close(ends_[0]);
    if (ends_[1] >= 0) ::close(ends_[1]);
  }
  std::unique_ptr<Operator> person(const std::string& typed) {
    EXPECT_EQ(::write(ends_[1], typed.data(), typed.size()), static_cast<ssize_t>(typed.size()));
    return make_terminal_operator(ends_[0], out_, [this] { end_input(); });
  }
  /// Nothing more comes: waiting has come to its end.
  void end_input() {
    ++waited_;
    ::close(ends_[1]);
    ends_[1] = -1;
  }
  int ends_[2] = {-1, -1};
  int waited_ = 0;
  std::ostringstream out_;
};

TEST_F(Asked, TakesWhatCanBeReadAndAsksAgainOtherwise) {
  const auto a = person("maybe\n y \n12,5\n+12.5\n 140 -5\n-5 140\n");
  EXPECT_TRUE(a->ask_yes("elbow", "positive", "positive?"));
  EXPECT_EQ(a->ask_deg("elbow", "here_deg", "where?"), 12.5);
  EXPECT_EQ(a->ask_range_deg("elbow", "free_deg", "how far?"), std::make_pair(-5.0, 140.0));
  EXPECT_NE(out_.str().find("elbow: positive? [y/n] "), std::string::npos);
  EXPECT_NE(out_.str().find("must be two numbers, the lower first, or q to leave"), std::string::npos) << out_.str();
}

TEST_F(Asked, GivesUpAfterThreeAtQAndAtTheEnd) {
  const auto a = person("x\nnan\n1e999\nq\n");
  EXPECT_THROW(a->ask_deg("elbow", "here_deg", "where?"), CommandFailed);
  EXPECT_THROW(a->ask_yes("elbow", "positive", "positive?"), CommandFailed) << "q";
  EXPECT_EQ(waited_, 0);
  EXPECT_THROW(a->ask_yes("elbow", "positive", "positive?"), CommandFailed) << "the end";
  EXPECT_EQ(waited_, 1) << "the lease lives while a person thinks";
}

TEST(AnswersFile, IsReadStrictly) {
  const auto file =
      std::filesystem::path(testing::TempDir()) / ("armsight-answers-" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << "elbow: {here_deg: 12.5, positive: maybe, up_deg: 14.5, free_deg: [140, -5], down: 3}\n";
  try {
    read_answers(file, {"elbow", "wrist"});
    ADD_FAILURE();
  } catch (const ConfigError& e) {
    const std::string all = e.what();
    for (const char* part :
         {":1:1: wrist: missing", "elbow.down_deg: missing", "elbow.positive = maybe: must be true or false",
          "elbow.free_deg: the first must be below the second", "elbow.down: unknown key"})
      EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace armsight::host
