// demo_run: the whole job on the simulated robot, with the very programs a user deploys, and its report.
// Started by the script tools/demo, which installs and builds first.
#include <csignal>
#include <cstdio>
#include <fstream>

#include "tools/command_line.hpp"
#include "tools/report/bars.hpp"
#include "tools/report/demo_session.hpp"

namespace {

namespace fs = std::filesystem;
using namespace armsight::demo;

constexpr double kLargestSeed = 9007199254740991.0;  // what every reader of report.json keeps exactly

void interrupt(int) { Conductor::is_interrupted = 1; }

void add_options(armsight::tools::CommandLine& line, DemoOptions& options) {
  options.home = fs::current_path();
  line.add("--seed", options.seed, "which robot, camera mount and noise").between(0, kLargestSeed).show_default();
  line.add("--report", options.report_dir, "folder for report.html and report.json (default HOME/out/demo)");
  line.add("--robot", options.robot_file, "robot file (default HOME/tools/experiments/demo_robot.yaml)");
  line.add("--noise", options.noise, "noise set").one_of({"clean", "nominal", "hard"}).show_default();
  line.add("--can", options.can_interfaces, "CAN interface, once a bus, not the emulated one; implies --pace real");
  line.add("--pace", options.pace, "pace").one_of({"lockstep", "real"}).show_default();
  line.add("--home", options.home, "folder of the repository").existing_folder();
}

void complete(DemoOptions& options) {
  options.home = fs::absolute(options.home);
  options.programs = fs::read_symlink("/proc/self/exe").parent_path();
  if (options.report_dir.empty()) options.report_dir = options.home / "out/demo";
  if (options.robot_file.empty()) options.robot_file = options.home / "tools/experiments/demo_robot.yaml";
  options.report_dir = fs::absolute(options.report_dir);
  options.robot_file = fs::absolute(options.robot_file);
  if (!options.can_interfaces.empty()) options.pace = "real";
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw RunFailed(file.string() + ": cannot be written", 1);
}

int conclude(const Report& r, const DemoOptions& options) {
  write(options.report_dir / "report.json", to_json(r));
  write(options.report_dir / "report.html", to_html(r));
  std::printf("demo: Learn: held-out hand pose error %.2f mm, %.2f deg RMS\n", r.heldout.rms_mm, r.heldout.rms_deg);
  std::printf("demo: Adapt: commanded poses %.2f mm without, %.2f mm with filter (median)\n",
              median_model_error(r.without_filter).mm, median_model_error(r.with_filter).mm);
  for (const auto& [name, result, g] :
       {std::tuple{"without", &r.grasp_without, &r.without_grasp}, {"with", &r.grasp_with, &r.with_grasp}}) {
    std::printf("demo: Act: grasp %s filter: %s", name, g->is_success ? "held" : "not held");
    if (g->was_closed) std::printf(" (%.2f mm, %.2f deg)", g->error.mm, g->error.deg);
    std::printf("%s%s\n", result->why.empty() ? "" : ": ", result->why.c_str());
  }
  std::printf("demo: report: %s\n", (options.report_dir / "report.html").c_str());
  const std::vector<std::string> missed = missed_figures(r);
  for (const std::string& figure : missed) std::fprintf(stderr, "demo: missed: %s\n", figure.c_str());
  return missed.empty() ? 0 : 1;
}

int fail(int code, const std::string& text) {
  std::fprintf(stderr, "demo: %s\n", text.c_str());
  return code;
}

}  // namespace

int main(int argc, char** argv) try {
  DemoOptions options;
  armsight::tools::CommandLine line(
      "The whole job on the simulated robot: calibrate, drift, adapt, grasp; writes a report.\n"
      "Exit code 1 where a figure is missed: held-out error above 2.4 mm or 1.1 deg, commanded poses with filter above "
      "3.4 mm or 1.2 deg (median); with --noise clean half, with hard twice that.",
      "demo_run");
  add_options(line, options);
  if (const auto code = line.parse(argc, argv)) return *code;
  complete(options);
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  return conclude(run_demo(options), options);
} catch (const armsight::ConfigError& e) {
  return fail(2, e.what());
} catch (const ProgramLost& e) {
  return fail(3, e.what());
} catch (const RunFailed& e) {
  return fail(e.exit_code, e.what());
} catch (const Interrupted&) {
  return fail(1, "interrupted; all programs were ended");
} catch (const std::exception& e) {
  return fail(1, e.what());
}
