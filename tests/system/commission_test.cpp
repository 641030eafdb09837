// Only here: an arm built otherwise than its robot file says is led through `host commission`, and then does what it is
// asked. Judged by the simulator's truth. The operator's eyes are the truth, too: what they see is known beforehand.
#include <fstream>
#include <iterator>

#include "protocol/strict_yaml.hpp"
#include "tests/system/system_rig.hpp"
#include "tools/sim/truth.hpp"

namespace armsight::demo {
namespace {

constexpr int kElbow = 3, kForearm = 4;

std::string drive(int node, const std::string& rest) {
  return "{node: " + std::to_string(node) + ", counts_per_turn: " + rest + "}";
}

class Commission : public SystemTest {
 protected:
  std::filesystem::path write_robot(const std::string& name, const std::string& elbow,
                                    const std::string& forearm) const {
    std::string text = read_text_file(quiet_robot().robot_file);
    for (const auto& [node, rest] : {std::pair(4, elbow), std::pair(5, forearm)}) {
      const std::string old = drive(node, "32768, sign: 1, zero_rad: 0, commissioned: true");
      text.replace(text.find(old), old.size(), drive(node, rest));
    }
    std::ofstream(robot_file(name)) << text;
    return robot_file(name);
  }
  void start_new_arm() {
    DemoOptions options = quiet_robot();
    options.robot_file =
        write_robot("new.yaml", "32768, sign: 1, zero_rad: 0", "32768, sign: 1, zero_rad: 0, commissioned: false");
    options.true_robot_file = write_robot("built.yaml", "65536, gear: 2, sign: -1, zero_rad: 0.3, commissioned: true",
                                          "32768, sign: 1, zero_rad: -0.5, commissioned: true");
    const RobotConfig built = load_robot(options.true_robot_file);
    const sim::Scene scene = sim::load_scene((options.home / "tools/sim/scene.yaml").string());
    start_rad_ = sim::make_truth(built, scene, sim::NoiseSet::kClean, sim::CameraMount::kNear, options.seed).start_rad;
    start(options);
  }
  /// 2° by the file's elbow are 1° the other way.
  std::string right_answers() const { return answers(0.0, 0.0); }
  /// With these many degrees beside the truth of the elbow.
  std::string answers(double up_off_deg, double down_off_deg) const {
    char text[400];
    const double elbow = start_rad_[kElbow] / kDegree, forearm = start_rad_[kForearm] / kDegree;
    std::snprintf(
        text, sizeof text,
        "elbow_flexion: {here_deg: %.3f, positive: false, up_deg: %.3f, down_deg: %.3f, free_deg: [-10, 140]}\n"
        "forearm_roll: {here_deg: %.3f, positive: true, up_deg: %.3f, down_deg: %.3f, free_deg: [-100, 100]}\n",
        elbow, elbow - 1.0 + up_off_deg, elbow + 1.0 + down_off_deg, forearm, forearm + 2.0, forearm - 2.0);
    return text;
  }
  int commission(const std::string& answers, const std::vector<std::string>& more = {}) {
    std::ofstream(robot_file("answers.yaml")) << answers;
    std::vector<std::string> words{
        "commission",      "--answers", robot_file("answers.yaml").string(), "--out", robot_file("out.yaml").string(),
        "--tolerance-deg", "0.04"};
    words.insert(words.end(), more.begin(), more.end());
    return arm().host(words);
  }
  std::string said(const std::string& what) {
    for (const std::string& line : arm().host_lines())
      if (line.find(what) != std::string::npos) return line;
    return arm().host_lines().empty() ? "nothing" : arm().host_lines().back();
  }
  bool has_out() const { return std::filesystem::exists(robot_file("out.yaml")); }

  JointVector start_rad_;
};

TEST_F(Commission, MakesAnArmGoWhereItIsAsked) {
  start_new_arm();
  ASSERT_EQ(arm().host({"move", "--joints=0.2,-0.2,-0.2,1.0,0.0"}), 1);
  EXPECT_NE(said("refused").find("joint elbow_flexion is not commissioned: host commission"), std::string::npos)
      << said("refused");
  ASSERT_EQ(commission(right_answers()), 0) << said("commission");
  EXPECT_NE(said("elbow_flexion: sign").find("sign -1 (was 1), scale times 0.5000"), std::string::npos)
      << said("elbow_flexion: sign");
  EXPECT_NE(said("forearm_roll: sign").find("sign 1 as it was, scale as it was"), std::string::npos)
      << said("forearm_roll: sign");
  ASSERT_TRUE(has_out());

  conductor().kill("arm_controller");
  conductor().run_cycles(100);
  std::filesystem::rename(robot_file("out.yaml"), robot_file("new.yaml"));
  arm().start_controller();
  ASSERT_EQ(arm().host({"move", "--joints=0.2,-0.2,-0.2,1.0,0.4"}), 0) << said("move");
  const Truth truth = arm().finish();
  const double goal[] = {0.2, -0.2, -0.2, 1.0, 0.4};
  // What the operator measured were real angles: these joints need no learnt offset any more, the others still do.
  for (int j = 0; j < kElbow; ++j) EXPECT_NEAR(truth.rows.back().q_reading[j], goal[j], 0.004) << "joint " << j + 1;
  for (const int j : {kElbow, kForearm}) EXPECT_NEAR(truth.rows.back().q_true[j], goal[j], 0.006) << "joint " << j + 1;
  double farthest = 0.0;  // until the controller was ended: 2° of the forearm, 1° of the elbow, and nothing else
  for (const TruthRow& row : truth.rows)
    if ((row.q_true - start_rad_).cwiseAbs().head(3).maxCoeff() < 1e-3)
      farthest = std::max(farthest, std::abs(row.q_true[kElbow] - start_rad_[kElbow]));
  EXPECT_NEAR(farthest, 1.0 * kDegree, 0.1 * kDegree);
}

TEST_F(Commission, RefusesEachWrongAnswerAndWritesNothing) {
  start_new_arm();
  const struct {
    const char *from, *to, *complaint;
  } wrong[] = {{"positive: false", "positive: true", "is said to have turned in its positive direction"},
               {"free_deg: [-10, 140]", "free_deg: [10, 140]", "it is free from"},
               {"elbow_flexion: {here_deg: ", "elbow_flexion: {here_deg: 1", "do not fit its encoder"}};
  for (const auto& one : wrong) {
    std::string answers = right_answers();
    answers.replace(answers.find(one.from), std::string(one.from).size(), one.to);
    EXPECT_EQ(commission(answers), 1) << one.to;
    EXPECT_NE(said("commission: elbow_flexion").find(one.complaint), std::string::npos)
        << one.to << ": " << said("commission: elbow_flexion");
    EXPECT_FALSE(has_out());
  }
  for (const auto& [up_off, down_off] : {std::pair(-0.3, 0.0), std::pair(0.0, 0.3), std::pair(0.3, 0.0)}) {
    EXPECT_EQ(commission(answers(up_off, down_off)), 1) << up_off << " " << down_off;
    EXPECT_NE(said("commission: elbow_flexion").find("do not fit its encoder"), std::string::npos)
        << said("commission: elbow_flexion");
    EXPECT_FALSE(has_out());
  }
  EXPECT_EQ(commission(right_answers(), {"--joint", "wrist"}), 2);
  EXPECT_EQ(commission(right_answers(), {"--dry-run"}), 0);
  EXPECT_FALSE(has_out());
}

}  // namespace
}  // namespace armsight::demo
