// host: sees, learns, adapts, grasps. This file is the command line alone; run_verb.cpp does the rest.
#include "host/command_line.hpp"
#include "host/parse_flags.hpp"

namespace {

using armsight::host::CommandLine;
using armsight::host::Verb;

void add_connection(CLI::App& app, CommandLine& line) {
  app.add_option("--arm", line.arm, "arm controller, ADDR:PORT");
  app.add_option("--state", line.state, "folder for results, pictures and the calibration")->capture_default_str();
  app.add_option("--robot", line.robot, "robot file; must describe the arm as the controller's does")
      ->capture_default_str();
  app.add_option("--camera", line.camera, "sim:ADDR:PORT | v4l2:DEV | video:FILE | folder:DIR");
  app.add_option("--intrinsics", line.intrinsics,
                 "camera intrinsics, ROS camera_info or OpenCV YAML; sim announces its own");
  app.add_option("--clock", line.clock, "sim:PATH joins the simulated robot's clock; default: the machine's");
  app.add_flag("--clear-fault", line.clear_fault, "clear a latched fault before taking command");
}

CLI::App* add_verb(CLI::App& app, CommandLine& line, const std::string& name, const std::string& help, Verb verb) {
  CLI::App* sub = app.add_subcommand(name, help);
  sub->callback([&line, verb] { line.verb = verb; });
  sub->fallthrough();
  return sub;
}

// What every verb that moves understands.
void add_motion(CLI::App* verb, CommandLine& line) {
  verb->add_option("--speed", line.speed, "share of the working speed")->check(CLI::Range(0.1, 1.0));
  verb->add_flag("--dry-run", line.dry_run, "show what would be done; nothing moves");
}

void add_learning(CLI::App& app, CommandLine& line) {
  CLI::App* calibrate =
      add_verb(app, line, "calibrate", "learn camera pose and joint offsets by moving and looking, or from a data set",
               Verb::kCalibrate);
  calibrate->add_option("--looks", line.looks, "accepted looks to make (20)")->check(CLI::Range(6, 200));
  calibrate
      ->add_option("--target-sigma-mm", line.target_sigma_mm, "stop when the hand is known better than this; 0: never")
      ->check(CLI::Range(0.0, 100.0));
  calibrate->add_option("--dataset", line.dataset, "folder with dataset.yaml and samples; needs no arm");
  calibrate->add_option("--out", line.out, "with --dataset: JSON file to write");
  calibrate->add_option("--cost", line.cost, "with --dataset: what is made small (default likelihood)")
      ->check(CLI::IsMember({"likelihood", "poses", "pixels", "thesis"}));
  add_motion(calibrate, line);
  CLI::App* adapt = add_verb(app, line, "adapt", "correct the model by a few looks at the hand", Verb::kAdapt);
  adapt->add_option("--looks", line.looks, "looks to make (5)")->check(CLI::Range(1, 50));
  adapt->add_option("--target-sigma-mm", line.target_sigma_mm, "stop when the hand is known better than this; 0: never")
      ->check(CLI::Range(0.0, 100.0));
  add_motion(adapt, line);
}

void add_acting(CLI::App& app, CommandLine& line) {
  CLI::App* grasp = add_verb(app, line, "grasp", "find an object by its marker and grasp it", Verb::kGrasp);
  grasp->add_option("--object", line.object, "name in the grasp table")->required();
  grasp->add_option("--grasps", line.grasps, "grasp table")->capture_default_str();
  grasp->add_option("--then", line.then, "with the object: lift | retreat | stay")
      ->capture_default_str()
      ->check(CLI::IsMember({"lift", "retreat", "stay"}));
  add_motion(grasp, line);
  CLI::App* move = add_verb(app, line, "move", "drive to a posture or a hand pose", Verb::kMove);
  CLI::Option* named = move->add_option("posture", line.posture, "one of the robot file's named postures");
  CLI::Option* joints =
      move->add_option("--joints", line.joints_rad, "real joint angles in rad, q1,q2,…")->delimiter(',');
  CLI::Option* pose = move->add_option("--pose", line.pose, "hand in the base: x,y,z in m, then qw,qx,qy,qz")
                          ->delimiter(',')
                          ->expected(7);
  joints->excludes(pose);
  named->excludes(joints)->excludes(pose);
  add_motion(move, line);
  CLI::App* park = add_verb(app, line, "park", "drive to the posture where the arm may be left", Verb::kPark);
  park->add_option("posture", line.posture, "of the robot file; default: park");
  park->add_flag("--disable", line.power_off, "then take the power off");
  add_motion(park, line);
  CLI::App* hand = add_verb(app, line, "hand", "open or close the hand", Verb::kHand);
  hand->add_option("what", line.hand, "open | close")->required()->check(CLI::IsMember({"open", "close"}));
  hand->add_option("--force", line.force_permille, "grip limit in per mille of the rated force")
      ->check(CLI::Range(1.0, 1000.0));
  add_motion(hand, line);
}

void add_commission(CLI::App& app, CommandLine& line) {
  CLI::App* commission =
      add_verb(app, line, "commission", "lead through new joints one by one: sign, scale, zero, limits, stop",
               Verb::kCommission);
  commission->add_option("--joint", line.commission_joints,
                         "this one; may be repeated (all that are not commissioned)");
  commission->add_option("--answers", line.answers, "YAML file of answers; default: asks at the terminal");
  commission->add_option("--tolerance-deg", line.tolerance_deg, "how exactly the angles are measured")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 1.0));
  commission->add_option("--out", line.out, "robot file to write")->required();
  commission->add_flag("--dry-run", line.dry_run, "show what would be done; nothing moves");
  CLI::App* stiffness = add_verb(app, line, "stiffness", "how stiff the joints are, where their drives can be told",
                                 Verb::kStiffness);
  stiffness
      ->add_option("permille", line.stiffness_permille, "per mille of the robot file's, one for all or one a joint")
      ->required()
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1000.0));
}

void add_watching(CLI::App& app, CommandLine& line) {
  add_verb(app, line, "enable", "power on, hold where it stands", Verb::kEnable);
  add_verb(app, line, "disable", "power off; an arm without brakes sinks", Verb::kDisable);
  add_verb(app, line, "clear", "clear a latched fault; the power stays off", Verb::kClear);
  CLI::App* status = add_verb(app, line, "status", "tell mode, joints, model, faults and statistics", Verb::kStatus);
  status->add_option("--out", line.out, "JSON file for the statistics, with all histograms");
  CLI::Option* watch = status->add_flag("--watch", line.watch, "go on telling what changes; connects again by itself");
  status->add_option("--for", line.watch_s, "seconds to watch; 0: until Ctrl-C")
      ->check(CLI::Range(0.0, 1e6))
      ->needs(watch);
  CLI::App* box =
      add_verb(app, line, "blackbox", "fetch the newest black box: the cycles before the last fault", Verb::kBlackBox);
  box->add_option("--out", line.out, "FILE.mcap to write")->required();
  add_verb(app, line, "stop", "stop the arm and hold; works whoever commands it", Verb::kStop);
}

void add_tools(CLI::App& app, CommandLine& line) {
  CLI::App* print = app.add_subcommand("print", "print things to the scale of the world");
  print->require_subcommand(1);
  CLI::App* marker = add_verb(*print, line, "marker", "a marker with a 100 mm ruler", Verb::kPrintMarker);
  marker->add_option("--id", line.marker_id, "marker id; default: the hand's")->check(CLI::Range(0, 1023));
  marker->add_option("--size-mm", line.marker_size_mm, "outer edge of the black border; default: the hand's")
      ->check(CLI::Range(5.0, 500.0));
  marker->add_option("--dictionary", line.dictionary, "default: the hand's");
  marker->add_option("--out", line.out, "FILE.svg or FILE.pdf")->required();
  CLI::App* robot = app.add_subcommand("robot", "robot files");
  robot->require_subcommand(1);
  CLI::App* import = add_verb(*robot, line, "import", "make a robot file from a URDF", Verb::kRobotImport);
  import->add_option("urdf", line.urdf, "URDF file")->required();
  import->add_option("--base", line.base_link, "link the chain starts from")->required();
  import->add_option("--tip", line.tip_link, "link that is the hand")->required();
  import->add_option("--out", line.out, "robot file to write")->required();
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine line;
  CLI::App app("host: sees the arm, learns its camera and joint offsets, adapts them and grasps", "host");
  app.require_subcommand(1);
  app.fallthrough();
  add_connection(app, line);
  add_learning(app, line);
  add_acting(app, line);
  add_commission(app, line);
  add_watching(app, line);
  add_tools(app, line);
  if (const auto code = armsight::host::parse_flags(app, argc, argv)) return *code;
  return armsight::host::run(line);
}
