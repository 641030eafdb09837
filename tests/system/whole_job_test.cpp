// Only here: the whole job through demo_run (specification E9 in small), and that a run does not depend on the machine.
#include <algorithm>
#include <atomic>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

int run_to_end(const std::vector<std::string>& command, std::string& output) {
  ChildProcess child("demo_run", command);
  while (!child.exit_code()) {
    child.drain({});
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  child.drain({});
  output = child.last_lines();
  return *child.exit_code();
}

/// What the machine's speed decides, and only that.
void drop_wall_figures(json& j) {
  if (j.is_object()) {
    for (auto it = j.begin(); it != j.end();) {
      const std::string& key = it.key();
      if (key == "solve_ms" || key.starts_with("tick_us_") || key.ends_with("_wall_s")) it = j.erase(it);
      else drop_wall_figures(*it++);
    }
  } else if (j.is_array()) {
    for (json& element : j) drop_wall_figures(element);
  }
}

class WholeJob : public SystemTest {
 protected:
  json run_demo_program(const std::string& name) {
    const DemoOptions options = quiet_robot();
    std::string output;
    const fs::path report = folder_ / name;
    fs::create_directories(folder_);
    const int code = run_to_end({(options.programs / "demo_run").string(), "--home", options.home.string(), "--seed",
                                 "1", "--noise", "nominal", "--report", report.string()},
                                output);
    EXPECT_EQ(code, 0) << output;
    std::ifstream in(report / "report.json");
    EXPECT_TRUE(fs::exists(report / "report.html"));
    return in ? json::parse(in) : json();
  }
};

TEST_F(WholeJob, MeetsItsFiguresAndGivesTheSameReportUnderLoad) {
  json quiet = run_demo_program("quiet");
  std::atomic<bool> is_over = false;
  std::thread load([&] { while (!is_over) {} });
  json loaded = run_demo_program("loaded");
  is_over = true;
  load.join();
  ASSERT_TRUE(quiet.is_object() && loaded.is_object());

  EXPECT_LE(quiet["calibrate"]["heldout_rms_mm"], 2.0);
  EXPECT_LE(quiet["calibrate"]["heldout_rms_deg"], 0.9);
  std::vector<double> with = quiet["adapt"]["with_filter_mm"], without = quiet["adapt"]["without_filter_mm"];
  EXPECT_LE(median(with), 2.5);
  EXPECT_GE(median(without), 3 * median(with)) << "the drift must be worth a filter";
  EXPECT_TRUE(quiet["grasp"]["with_filter"]["success"].get<bool>());
  for (const char* filter : {"with_filter", "without_filter"})
    EXPECT_TRUE(quiet["grasp"][filter]["verdict_agrees_with_truth"].get<bool>()) << filter;
  EXPECT_EQ(quiet["controller"]["missed"], 0);
  for (const char* run : {"quiet", "loaded"}) {
    for (const auto& entry : fs::directory_iterator(folder_ / run / "run/controller"))
      EXPECT_FALSE(entry.path().filename().string().starts_with("blackbox")) << "a watchdog fired: " << entry.path();
  }

  drop_wall_figures(quiet);
  drop_wall_figures(loaded);
  EXPECT_EQ(quiet.dump(1), loaded.dump(1));
}

}  // namespace
}  // namespace armsight::demo
