#include "tools/report/demo_session.hpp"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>

namespace armsight::demo {

namespace {

namespace fs = std::filesystem;

std::string read_text(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string joint_list(const JointVector& q) {
  std::ostringstream text;
  for (int i = 0; i < q.size(); ++i) text << (i == 0 ? "" : ",") << q(i);
  return text.str();
}

class Session {
 public:
  Session(const DemoOptions& options, const RobotConfig& robot, const Experiment& experiment)
      : options_(options), robot_(robot), experiment_(experiment), arm_(options, options.report_dir / "run", true) {}

  Report run();

 private:
  template <typename Work>
  void phase(const std::string& name, Work&& work);
  int verb(const std::vector<std::string>& words, const std::string& result, const std::string& kept_as);
  void must(int exit_code, const std::string& what);
  std::vector<MoveResult> moves(const std::string& kept_as);
  GraspResult grasp(const std::string& kept_as, const std::string& then);
  void read_status();
  void keep_images(const std::vector<std::string>& names, const std::string& caption, std::size_t most);
  void keep_grasp_images(const GraspResult& grasp, const std::string& caption);
  fs::path results() const { return arm_.run_dir() / "results"; }
  void describe();

  const DemoOptions& options_;
  const RobotConfig& robot_;
  const Experiment& experiment_;
  RunningArm arm_;
  Report report_;
};

template <typename Work>
void Session::phase(const std::string& name, Work&& work) {
  std::printf("demo: %s\n", name.c_str());
  std::fflush(stdout);
  const auto wall_begin = std::chrono::steady_clock::now();
  const double begin_s = arm_.conductor().time_s();
  work();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_begin;
  report_.phases.push_back({name, arm_.conductor().time_s() - begin_s, wall.count()});
}

/// Runs a verb; its result file, where it wrote one, is kept beside those of the other phases.
int Session::verb(const std::vector<std::string>& words, const std::string& result, const std::string& kept_as) {
  const fs::path written = arm_.run_dir() / "host" / (result + ".json");
  if (!result.empty()) fs::remove(written);
  const int code = arm_.host(words);
  if (code > 3) throw ProgramLost("host " + words.front() + " was ended by signal " + std::to_string(code - 128));
  if (code > 1) throw RunFailed("host " + words.front() + " ended with exit code " + std::to_string(code), code);
  if (!result.empty() && fs::exists(written)) fs::copy_file(written, results() / (kept_as + ".json"));
  return code;
}

void Session::must(int exit_code, const std::string& what) {
  if (exit_code != 0) throw RunFailed(what + " (the host's lines stand above)", 1);
}

std::vector<MoveResult> Session::moves(const std::string& kept_as) {
  std::vector<MoveResult> results;
  for (const JointVector& q : experiment_.commanded_q_real) {
    const std::string name = kept_as + "-" + std::to_string(results.size() + 1);
    must(verb({"move", "--joints=" + joint_list(q)}, "move", name), "commanded pose " + name + " was not reached");
    results.push_back(load_move(this->results() / (name + ".json")));
  }
  return results;
}

GraspResult Session::grasp(const std::string& kept_as, const std::string& then) {
  const std::string table = (options_.home / "host/config/grasps.yaml").string();
  verb({"grasp", "--object", experiment_.object, "--then", then, "--grasps", table}, "grasp", kept_as);
  return load_grasp(results() / (kept_as + ".json"));
}

void Session::read_status() {
  const fs::path file = results() / "status.json";
  must(arm_.host({"status", "--out", file.string()}), "host status failed");
  static_cast<ControllerStatus&>(report_.controller) = load_status(file);
  for (const std::string& line : arm_.host_lines()) {
    char name[64] = {}, version[64] = {};
    if (std::sscanf(line.c_str(), "controller: %63s %63[^,],", name, version) == 2) report_.versions[name] = version;
  }
}

void Session::keep_images(const std::vector<std::string>& names, const std::string& caption, std::size_t most) {
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) {
    if (names[i].empty()) continue;
    const std::size_t picked = most >= names.size() ? i : i * (names.size() - 1) / std::max<std::size_t>(1, most - 1);
    const fs::path kept = results() / ("image-" + std::to_string(report_.images.size() + 1) +
                                       fs::path(names[picked]).extension().string());
    fs::copy_file(arm_.run_dir() / "host" / names[picked], kept);
    report_.images.push_back({caption + " " + std::to_string(picked + 1), kept});
  }
}

void Session::keep_grasp_images(const GraspResult& grasp, const std::string& caption) {
  std::vector<std::string> seen = grasp.images;
  std::erase(seen, grasp.image_closed);
  keep_images(seen, caption + "the object as seen, view", 2);
  keep_images({grasp.image_closed}, caption + "the hand closed, view", 1);
}

void Session::describe() {
  report_.seed = options_.seed;
  report_.noise = options_.noise;
  report_.pace = options_.pace;
  report_.bus = options_.can_interfaces.empty() ? "emulated" : "socketcan";
  const std::string& line = arm_.bus_line();
  const auto open = line.find('(');
  report_.bus_line = "Bus: " + (open == std::string::npos ? line : line.substr(open + 1, line.find(')') - open - 1));
  report_.robot_name = robot_.robot;
  report_.object = experiment_.object;
  for (const char* program : {"arm_sim", "arm_controller", "host", "demo_run"})
    report_.versions[program] = ARMSIGHT_VERSION;
  for (const fs::path& file : {options_.robot_file, options_.home / "tools/experiments/chapter8.yaml",
                               options_.home / "tools/sim/scene.yaml", options_.home / "host/config/grasps.yaml"}) {
    report_.inputs.emplace_back(file.filename().string(), read_text(file));
  }
}

Report Session::run() {
  for (const char* stale : {"report.html", "report.json"}) fs::remove(options_.report_dir / stale);  // of another run
  describe();
  std::printf("demo: bus in use: %s\n", arm_.bus_line().c_str());
  std::vector<MoveResult> without, with;
  phase("Learn: calibrate", [&] {
    must(verb({"calibrate"}, "calibrate", "calibrate"), "calibrate failed");
    report_.calibrate = load_calibrate(results() / "calibrate.json");
    std::vector<std::string> images;
    for (const CalibrationLook& look : report_.calibrate.looks) images.push_back(look.image);
    keep_images(images, "Learn: look", 4);
  });
  phase("drift: the camera is knocked, the joints shift", [&] { arm_.conductor().inject_drift(); });
  phase("commanded poses without filter", [&] { without = moves("move-without"); });
  phase("Act: grasp without filter", [&] {
    report_.grasp_without = grasp("grasp-without", "stay");  // the next one finds the object where it was
    keep_grasp_images(report_.grasp_without, "Act: without filter, ");
    must(verb({"hand", "open"}, "", ""), "the hand did not open");
  });
  phase("Adapt: looks and filter", [&] {
    must(verb({"adapt"}, "adapt", "adapt"), "adapt failed");
    report_.adapt = load_adapt(results() / "adapt.json");
    std::vector<std::string> images;
    for (const AdaptLook& look : report_.adapt.looks) images.push_back(look.image);
    keep_images(images, "Adapt: look", images.size());
  });
  phase("commanded poses with filter", [&] { with = moves("move-with"); });
  phase("Act: grasp with filter", [&] {
    report_.grasp_with = grasp("grasp-with", "lift");
    keep_grasp_images(report_.grasp_with, "Act: with filter, ");
  });
  phase("the controller's statistics", [&] { read_status(); });
  evaluate(report_, arm_.finish(), without, with, robot_, experiment_);
  report_.controller.black_boxes = arm_.black_boxes();
  report_.commands = arm_.commands();
  return std::move(report_);
}

}  // namespace

Report run_demo(const DemoOptions& options) {
  const RobotConfig robot = load_robot(options.robot_file);
  const Experiment experiment = load_experiment(options.home / "tools/experiments/chapter8.yaml", robot);
  return Session(options, robot, experiment).run();
}

}  // namespace armsight::demo
