#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "host/adapt.hpp"
#include "host/calibrate.hpp"
#include "host/command_line.hpp"
#include "host/commission.hpp"
#include "host/dry_run.hpp"
#include "host/grasp.hpp"
#include "host/host_io.hpp"
#include "host/learn_dataset.hpp"
#include "host/marker_print.hpp"
#include "host/power_verbs.hpp"
#include "host/small_verbs.hpp"
#include "host/status.hpp"
#include "host/urdf_import.hpp"
#include "protocol/atomic_file.hpp"

namespace armsight::host {
namespace {

constexpr const char* kSimClock = "sim:";

bool needs_camera(Verb verb) { return verb == Verb::kCalibrate || verb == Verb::kAdapt || verb == Verb::kGrasp; }
bool is_watching(Verb verb) { return verb == Verb::kStatus || verb == Verb::kStop || verb == Verb::kBlackBox; }
bool needs_command(const CommandLine& line) { return !is_watching(line.verb) && !line.dry_run; }
/// enable, disable and clear say themselves what is to become of the power.
bool needs_power(const CommandLine& line) {
  return needs_command(line) && line.verb != Verb::kStiffness && line.verb != Verb::kEnable &&
         line.verb != Verb::kDisable && line.verb != Verb::kClear;
}

HostIoOptions io_options(const CommandLine& line) {
  HostIoOptions options;
  if (line.arm.empty()) throw ConfigError("--arm: missing: must name the arm controller, ADDR:PORT");
  options.arm_address = line.arm;
  if (needs_camera(line.verb)) {
    if (line.camera.empty()) throw ConfigError("--camera: missing: this verb looks");
    options.camera_source = line.camera;
    options.intrinsics_file = line.intrinsics;
  }
  if (!line.clock.empty()) {
    if (!line.clock.starts_with(kSimClock)) throw ConfigError("--clock: " + line.clock + ": must be sim:PATH");
    options.sim_clock = line.clock.substr(std::string_view(kSimClock).size());
  }
  options.speed_scale = line.speed;
  options.role = needs_command(line) ? wire::ROLE_COMMAND : wire::ROLE_OBSERVE;
  return options;
}

bool is_finite(double value) { return std::isfinite(value); }

// CLI11 takes "nan" for a number and finds it in every range.
void check_numbers(const CommandLine& line) {
  const auto check = [](const char* flag, const std::vector<double>& values) {
    if (!std::all_of(values.begin(), values.end(), is_finite))
      throw ConfigError(std::string(flag) + ": must be finite");
  };
  check("--joints", line.joints_rad);
  check("--pose", line.pose);
  check("--speed", {line.speed});
  check("--for", {line.watch_s});
  check("--force", {line.force_permille});
  check("--target-sigma-mm", {line.target_sigma_mm});
  check("--size-mm", {line.marker_size_mm});
  check("--tolerance-deg", {line.tolerance_deg});
  check("stiffness", line.stiffness_permille);
}

std::optional<Pose> pose_goal(const CommandLine& line) {
  if (line.pose.empty()) {
    if (line.joints_rad.empty() && line.posture.empty())
      throw ConfigError("move: must name a posture, --joints or --pose");
    return std::nullopt;
  }
  const Eigen::Quaterniond q(line.pose[3], line.pose[4], line.pose[5], line.pose[6]);
  if (!(std::abs(q.norm() - 1.0) < 1e-3))
    throw ConfigError("--pose: quaternion of length " + std::to_string(q.norm()) + ": must be 1");
  return Pose{q.normalized().toRotationMatrix(), Vector3(line.pose[0], line.pose[1], line.pose[2])};
}

JointVector named_posture(const CommandLine& line, const RobotConfig& robot) {
  const std::string name = line.posture.empty() ? "park" : line.posture;
  if (const auto found = robot.postures.find(name); found != robot.postures.end()) return found->second;
  std::string known;
  for (const auto& [other, q] : robot.postures) known += (known.empty() ? "" : ", ") + other;
  throw ConfigError(name + ": no posture of " + line.robot + "; it has: " + (known.empty() ? "none" : known));
}

JointVector joint_goal(const CommandLine& line, const RobotConfig& robot) {
  if (line.verb == Verb::kPark || !line.posture.empty()) return named_posture(line, robot);
  if (line.joints_rad.empty()) return {};
  if (static_cast<int>(line.joints_rad.size()) != robot.arm.joint_count()) {
    throw ConfigError("--joints: " + std::to_string(line.joints_rad.size()) + " values: must be one a joint, " +
                      std::to_string(robot.arm.joint_count()));
  }
  return Eigen::Map<const Eigen::VectorXd>(line.joints_rad.data(), robot.arm.joint_count());
}

/// What the verbs' files are called; null: the verb leaves none.
const char* session_name(Verb verb) {
  switch (verb) {
    case Verb::kCalibrate: return "calibrate";
    case Verb::kAdapt: return "adapt";
    case Verb::kGrasp: return "grasp";
    case Verb::kMove: return "move";
    case Verb::kPark:
      return "park";
    default: return nullptr;
  }
}

void run_calibrate_verb(HostIo& io, SessionFiles& files, const CommandLine& line) {
  CalibrateOptions options;
  options.robot_file = line.robot;
  if (line.looks > 0) options.looks = line.looks, options.max_attempts = 2 * line.looks;
  options.target_sigma_m = line.target_sigma_mm * 1e-3;
  run_calibrate(io, files, options, std::cout);
}

void run_adapt_verb(HostIo& io, SessionFiles& files, const CommandLine& line) {
  AdaptOptions options;
  if (line.looks > 0) options.looks = line.looks, options.max_attempts = 2 * line.looks + 2;
  options.target_sigma_m = line.target_sigma_mm * 1e-3;
  run_adapt(io, files, options, std::cout);
}

GraspOptions grasp_options(const CommandLine& line) {
  GraspOptions options;
  options.then = line.then == "lift"      ? AfterGrasp::kLift
                 : line.then == "retreat" ? AfterGrasp::kRetreat
                                          : AfterGrasp::kStay;
  options.dry_run = line.dry_run;
  return options;
}

double closure_of(const CommandLine& line) { return line.hand == "close" ? 1.0 : 0.0; }

void run_park(HostIo& io, SessionFiles& files, const JointVector& q_park, const CommandLine& line) {
  run_move(io, files, q_park, std::nullopt, std::cout);
  if (line.power_off) run_disable(io, std::cout);
}

void show(HostIo& io, const CommandLine& line, const JointVector& q_goal, const std::optional<Pose>& T_B_G) {
  switch (line.verb) {
    case Verb::kMove:
      return show_move(io, "move", q_goal, T_B_G, std::cout);
    case Verb::kPark:
      return show_move(io, "park", q_goal, std::nullopt, std::cout);
    case Verb::kHand:
      return show_hand(io, closure_of(line), line.force_permille, std::cout);
    case Verb::kCalibrate:
      return show_looks(io, "calibrate", line.looks > 0 ? line.looks : CalibrateOptions{}.looks, std::cout);
    case Verb::kAdapt:
      return show_looks(io, "adapt", line.looks > 0 ? line.looks : AdaptOptions{}.looks, std::cout);
    default:
      break;
  }
}

CommissionOptions commission_options(const CommandLine& line, const RobotConfig& robot) {
  CommissionOptions options;
  if (line.verb != Verb::kCommission) return options;
  options.robot_file = line.robot;
  options.out_file = line.out;
  options.joints = joints_to_commission(robot, line.commission_joints);
  options.tolerance_rad = line.tolerance_deg * kDegree;
  return options;
}

/// A file of answers is read before anything moves.
std::unique_ptr<Operator> operator_of(const CommandLine& line, const RobotConfig& robot,
                                      const CommissionOptions& options) {
  if (line.verb != Verb::kCommission || line.answers.empty()) return nullptr;
  std::vector<std::string> names;
  for (const std::size_t joint : options.joints) names.push_back(robot.joint_names[joint]);
  return read_answers(line.answers, names);
}

void run_commission_verb(HostIo& io, std::unique_ptr<Operator> person, const CommissionOptions& options) {
  if (!person) person = make_terminal_operator(STDIN_FILENO, std::cout, [&io] { io.step(); });
  run_commission(io, *person, options, std::cout);
}

// Whoever stops the arm waits for no file, model or state: protocol/README.md asks for none of them.
void run_stop_verb(const CommandLine& line) {
  const RobotConfig no_robot{};
  catch_interrupts();
  HostIo io(io_options(line), no_robot);
  run_stop(io, std::cout);
}

// Everything that can be wrong with words, files and folders is found before anything is connected or moves.
void run_online(const CommandLine& line) {
  const RobotConfig robot = load_robot(line.robot);
  const HostIoOptions options = io_options(line);
  const std::optional<Pose> T_B_G = line.verb == Verb::kMove ? pose_goal(line) : std::nullopt;
  const JointVector q_goal = joint_goal(line, robot);
  const CommissionOptions commission = commission_options(line, robot);
  std::unique_ptr<Operator> person = operator_of(line, robot, commission);
  const std::vector<std::uint32_t> stiffness =
      line.verb == Verb::kStiffness ? stiffness_of(line.stiffness_permille, robot) : std::vector<std::uint32_t>();
  GraspTable table;
  if (line.verb == Verb::kGrasp) table = GraspTable::load(line.grasps);
  const GraspObject* object = line.verb == Verb::kGrasp ? &table.find(line.object) : nullptr;
  std::optional<SessionFiles> files;
  if (const char* name = session_name(line.verb)) files.emplace(line.state, name);

  cv::setNumThreads(1);  // the arm's loop may share this machine: no picture is worth all of its cores
  catch_interrupts();
  HostIo io(options, robot);
  open_session(io, needs_camera(line.verb));
  if (needs_power(line)) take_command(io, line.clear_fault);
  if (line.dry_run && line.verb == Verb::kCommission) return show_commission(robot, commission, std::cout);
  if (line.dry_run && line.verb != Verb::kGrasp) return show(io, line, q_goal, T_B_G);
  switch (line.verb) {
    case Verb::kCalibrate: run_calibrate_verb(io, *files, line); break;
    case Verb::kAdapt: run_adapt_verb(io, *files, line); break;
    case Verb::kGrasp:
      run_grasp(io, *files, *object, grasp_options(line), std::cout);
      break;
    case Verb::kMove:
      run_move(io, *files, q_goal, T_B_G, std::cout);
      break;
    case Verb::kPark:
      run_park(io, *files, q_goal, line);
      break;
    case Verb::kHand:
      run_hand(io, closure_of(line), line.force_permille, std::cout);
      break;
    case Verb::kEnable:
      run_enable(io, line.clear_fault, std::cout);
      break;
    case Verb::kDisable:
      run_disable(io, std::cout);
      break;
    case Verb::kClear:
      run_clear(io, std::cout);
      break;
    case Verb::kStatus:
      line.watch ? run_watch(io, line.watch_s, std::cout) : run_status(io, line.out, std::cout);
      break;
    case Verb::kCommission: run_commission_verb(io, std::move(person), commission); break;
    case Verb::kStiffness: run_stiffness(io, stiffness, std::cout); break;
    case Verb::kBlackBox: run_black_box(io, line.out, std::cout); break;
    default: break;
  }
}

void print_marker(const CommandLine& line) {
  MarkerConfig marker = load_robot(line.robot).hand_marker;
  if (line.marker_id >= 0) marker.id = line.marker_id;
  if (line.marker_size_mm > 0.0) marker.side_m = line.marker_size_mm * 1e-3;
  if (!line.dictionary.empty()) marker.dictionary = line.dictionary;
  save_marker_print(marker, line.out);
}

// The whole verb is one file: one that cannot be written is a bad flag.
void import_robot(const CommandLine& line) {
  const std::string robot = import_urdf(line.urdf, line.base_link, line.tip_link);
  try {
    write_file_atomically(line.out, robot);
  } catch (const std::runtime_error& error) {
    throw ConfigError(error.what());
  }
}

int fail(int code, const std::string& text) {
  std::cerr << "host: " << text << std::endl;
  return code;
}

}  // namespace

int run(const CommandLine& line) try {
  check_numbers(line);
  if (line.verb == Verb::kPrintMarker) {
    print_marker(line);
    return 0;
  }
  if (line.verb == Verb::kRobotImport) {
    import_robot(line);
    return 0;
  }
  if (line.verb == Verb::kCalibrate && !line.dataset.empty()) {
    return run_calibrate_dataset(line.dataset, line.out, learn_cost(line.cost), std::cout);
  }
  if (line.verb == Verb::kStop) run_stop_verb(line);
  else run_online(line);
  return 0;
} catch (const ConfigError& error) {
  return fail(2, error.what());
} catch (const PeerLost& error) {
  return fail(3, error.what());
} catch (const CameraLost& error) {
  return fail(3, error.what());
} catch (const net::ClockLost& error) {
  return fail(3, error.what());
} catch (const std::exception& error) {  // CommandFailed, Interrupted, a full disk, and what nobody foresaw
  std::string text = error.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return fail(1, text);
}

}  // namespace armsight::host
