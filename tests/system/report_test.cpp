// Only here: are the demo's figures what their names say? Evaluation and report on a run whose errors are known.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/system/synthetic_run.hpp"
#include "tools/report/report.hpp"

namespace armsight::demo {
namespace {

const std::filesystem::path kHome = ARMSIGHT_HOME;

class ReportTest : public testing::Test {
 protected:
  ReportTest() {
    run.write(folder);
    report.seed = 1;
    report.noise = "nominal";
    report.bus = "emulated";
    report.bus_line = "Bus: emulated, 1 Mbit/s";
    report.pace = "lockstep";
    report.robot_name = robot.robot;
    report.object = "can";
    report.versions = {{"arm_controller", "0.1.0"}, {"host", "0.1.0"}};
    report.phases = {{"Learn: calibrate", 62.1, 14.2}, {"Adapt: looks and filter", 12.3, 3.1}};
    report.controller = {{250, 12.1, 31.5, 40000, 0, {}}, {}};
    report.controller.durations = {{"tick", 40000, 12.1, 31.5, 40.0, {12100, 31500}, {39000, 1000}},
                                   {"TPDO1 of node 1", 3, 500.0, 900.0, 900.0, {500000, 900000}, {2, 1}}};
    report.calibrate = load_calibrate(folder / "calibrate.json");
    report.adapt = load_adapt(folder / "adapt.json");
    report.grasp_without = load_grasp(folder / "grasp-without.json");
    report.grasp_with = load_grasp(folder / "grasp-with.json");
    evaluate(report, load_truth(folder / "truth.json"), moves("without"), moves("with"), robot, experiment);
  }

  std::vector<MoveResult> moves(const std::string& name) {
    std::vector<MoveResult> out;
    for (int i = 1; i <= 5; ++i)
      out.push_back(load_move(folder / ("move-" + name + "-" + std::to_string(i) + ".json")));
    return out;
  }

  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("armsight-report-" + std::to_string(getpid()));
  RobotConfig robot = load_robot(kHome / "tools/experiments/demo_robot.yaml");
  Experiment experiment = load_experiment(kHome / "tools/experiments/chapter8.yaml", robot);
  SyntheticRun run{robot, experiment};
  Report report;

  void TearDown() override {
    if (std::getenv("ARMSIGHT_KEEP_REPORT") != nullptr)
      std::ofstream(std::getenv("ARMSIGHT_KEEP_REPORT")) << to_html(report);
    std::filesystem::remove_all(folder);
  }
};

TEST_F(ReportTest, HoldsOutAtLeastFortyPosturesAndSeesNoErrorInAnExactModel) {
  EXPECT_GE(report.heldout.postures, 40);
  EXPECT_LT(report.heldout.rms_mm, 1e-6);
  EXPECT_LT(report.heldout.rms_deg, 1e-5);
}

TEST_F(ReportTest, HeldOutErrorIsTheSizeOfAKnownShift) {
  LearnedModel shifted = report.calibrate.model;
  shifted.T_C_B.p.y() += 0.002;
  const HeldOut held =
      evaluate_heldout(load_truth(folder / "truth.json"), shifted, report.calibrate.looks, robot, experiment);
  EXPECT_NEAR(held.rms_mm, 2.0, 1e-6);
}

TEST_F(ReportTest, OffsetErrorsAreTakenAfterGaugeAlignmentAndNullWhereUnobservable) {
  ASSERT_EQ(report.parameters.beta_error_deg.size(), 5u);
  EXPECT_FALSE(report.parameters.beta_error_deg[0].has_value());
  for (int i = 1; i < 5; ++i)
    EXPECT_NEAR(report.parameters.beta_error_deg[static_cast<std::size_t>(i)].value(), 0.0, 1e-9);
  EXPECT_LT(report.parameters.camera.mm, 1e-6);
  EXPECT_LT(report.parameters.camera.deg, 1e-5);
}

TEST_F(ReportTest, ComparesTheModelsHandWithTheTrueOneAtTheSameInstant) {
  for (const CommandedPose& pose : report.with_filter) EXPECT_NEAR(pose.model_error.mm, 1.0, 1e-6);
  for (const CommandedPose& pose : report.without_filter) EXPECT_GT(pose.model_error.mm, 5.0);
}

TEST_F(ReportTest, TellsTheErrorAfterEachLookFromTheLearntModelOn) {
  ASSERT_EQ(report.after_looks.size(), 6u);
  EXPECT_GT(report.after_looks.front().mm, 5.0);
  EXPECT_NEAR(report.after_looks.back().mm, 1.0, 1e-6);
}

TEST_F(ReportTest, JudgesTheGraspByTheTruthNotByTheVerdict) {
  EXPECT_TRUE(report.with_grasp.is_success);
  EXPECT_TRUE(report.with_grasp.does_verdict_agree);
  EXPECT_FALSE(report.without_grasp.is_success);
  EXPECT_FALSE(report.without_grasp.does_verdict_agree);
  EXPECT_NEAR(1e3 * report.with_grasp.T_G_reached.p.norm(), 2.0, 0.01);
}

TEST_F(ReportTest, WritesTheKeysThatProgramsRelyOn) {
  const auto j = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(j.at("adapt").at("with_filter_mm").size(), 5u);
  EXPECT_EQ(j.at("adapt").at("without_filter_deg").size(), 5u);
  EXPECT_EQ(j.at("adapt").at("after_looks_mm").size(), 6u);
  EXPECT_EQ(j.at("calibrate").at("looks"), 20);
  EXPECT_TRUE(j.at("calibrate").at("beta_error_deg").at(0).is_null());
  for (const char* key : {"heldout_rms_mm", "heldout_rms_deg", "solve_ms", "rank", "unobservable"})
    EXPECT_TRUE(j.at("calibrate").contains(key)) << key;
  const auto& controller = j.at("controller");
  EXPECT_EQ(controller.at("tick_us_histogram").at(0).at("counts"), (std::vector{39000, 1000}));
  ASSERT_EQ(controller.at("durations").size(), 1u) << "the machine's speed must not be in it";
  EXPECT_EQ(controller.at("durations").at(0).at("name"), "TPDO1 of node 1");
  for (const char* key : {"rate_hz", "tick_us_p50", "tick_us_p999", "missed"})
    EXPECT_TRUE(j.at("controller").contains(key)) << key;
  EXPECT_EQ(j.at("programs").at("arm_controller").at("version"), "0.1.0");
  EXPECT_TRUE(j.at("grasp").at("with_filter").at("success").get<bool>());
}

TEST_F(ReportTest, DrawsHowTheDurationsOfTheCycleAreSpread) {
  const std::vector<Plot> plots = controller_figures(report);
  ASSERT_EQ(plots.size(), 2u);
  EXPECT_EQ(plots[1].series.at(0).y.back(), 100.0);
  EXPECT_NEAR(plots[1].series.at(0).y.at(1), 200.0 / 3.0, 1e-9);
  EXPECT_NE(to_html(report).find("TPDO1 of node 1"), std::string::npos);
}

TEST_F(ReportTest, HtmlNeedsNothingFromElsewhere) {
  const std::string html = to_html(report);
  for (const char* outside : {"src=\"http", "href=\"http", "@import", "url("})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  EXPECT_EQ(html.find("nan"), std::string::npos);
}

TEST(SvgPlot, TicksAreRoundAndInside) {
  EXPECT_EQ(nice_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  for (const double tick : nice_ticks(-0.37, 1.91, 6)) EXPECT_TRUE(tick >= -0.37 && tick <= 1.91);
  EXPECT_TRUE(nice_ticks(1, 1, 5).empty());
}

TEST(SvgPlot, NumbersAreShort) {
  EXPECT_EQ(short_number(19.437), "19.4");
  EXPECT_EQ(short_number(0.0), "0");
  EXPECT_EQ(short_number(1234.5), "1234");
  EXPECT_EQ(short_number(-0.250), "-0.25");
}

TEST(SvgPlot, LeavesOutWhatIsNotFiniteAndEscapesText) {
  const Plot plot{.title = "a < b", .series = {{.label = "s", .x = {0, 1, 2}, .y = {1, std::nan(""), 3}}}};
  const std::string svg = to_svg(plot);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
}

}  // namespace
}  // namespace armsight::demo
