// Only here: an arm of soft actuators, whose links hang degrees away from their drives, under the real controller that
// thinks them a fifth lighter than they are. Judged by what the simulator's encoders say of the links (F-S4).
#include <fstream>
#include <iterator>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class SoftArmOfTheProgram : public SystemTest {
 protected:
  /// The demo's robot with the masses of specification §4.4, each times `scale`, and the springs of the lab's arm.
  std::filesystem::path soft_robot(const std::string& name, double scale) const {
    const struct {
      double mass_kg;
      const char* com_m;
    } links[] = {{0.600, "[0, 0, 0]"}, {0.643, "[0, 0, 0.083]"}, {0.590, "[0, 0, 0]"}, {0.350, "[0, 0, 0.077]"},
                 {0.5, "[0, 0, 0]"}};
    std::ifstream in(quiet_robot().robot_file);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    std::size_t at = 0;
    for (const auto& link : links) {
      at = text.find("commissioned: true}}", at) + 19;
      text.insert(at, ",\n     link: {mass_kg: " + std::to_string(scale * link.mass_kg) + ", com_m: " + link.com_m +
                          "},\n     spring: {law: sinh, k_Nm: 0.02, a_per_rad: 11, preset_rad: 0.4, "
                          "max_deflection_rad: 0.8}");
    }
    const std::filesystem::path file = robot_file(name);
    std::ofstream(file) << text;
    return file;
  }
};

TEST_F(SoftArmOfTheProgram, StandsWithinATenthOfADegreeAndNeverJumps) {
  DemoOptions options = quiet_robot();
  options.robot_file = soft_robot("believed.yaml", 1.0);
  options.true_robot_file = soft_robot("true.yaml", 1.2);
  start(options);
  const double goals[][5] = {{0.2, -0.2, -0.2, 1.0, 0.0}, {1.2, 0.5, -1.0, 0.3, 0.4}, {-0.6, -1.0, 0.8, 1.8, -0.9}};
  std::vector<double> arrived_s;
  for (const auto& goal : goals) {
    std::string joints = "--joints=";
    for (const double q : goal) joints += (joints.back() == '=' ? "" : ",") + std::to_string(q);
    ASSERT_EQ(arm().host({"move", joints}), 0);
    arrived_s.push_back(conductor().time_s());
  }
  const double end_s = conductor().time_s();
  const Truth truth = arm().finish();
  double largest_rad = 0.0;
  for (std::size_t i = 0; i < arrived_s.size(); ++i) {
    const auto back = static_cast<std::size_t>((end_s - arrived_s[i]) / 0.004);
    const TruthRow& row = truth.rows.at(truth.rows.size() - 4 - back);
    for (int j = 0; j < 5; ++j) largest_rad = std::max(largest_rad, std::abs(row.q_reading[j] - goals[i][j]));
  }
  EXPECT_LT(largest_rad, 0.1 * kDegree);
  // Where power came on the links stood: the feed-forward lacks a fifth of the bend, no more may they sink.
  double farthest_rad = 0.0;
  for (std::size_t row = 0; row < 100; ++row)
    farthest_rad = std::max(farthest_rad, (truth.rows[row].q_true - truth.rows[0].q_true).cwiseAbs().maxCoeff());
  EXPECT_LT(farthest_rad, 2.5 * kDegree);
}

}  // namespace
}  // namespace armsight::demo
