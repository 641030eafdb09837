// What the operator asked for, as plain values: main.cpp fills it, run_verb.cpp acts on it.
#pragma once

#include <string>
#include <vector>

namespace armsight::host {

enum class Verb {
  kCalibrate,
  kAdapt,
  kGrasp,
  kMove,
  kPark,
  kHand,
  kEnable,
  kDisable,
  kClear,
  kStatus,
  kStop,
  kBlackBox,
  kCommission,
  kStiffness,
  kPrintMarker,
  kRobotImport
};

struct CommandLine {
  Verb verb = Verb::kStatus;
  std::string arm, state = "state/host", robot = "arm_controller/config/ego_right_arm.yaml";
  std::string camera, intrinsics, clock;
  bool clear_fault = false;

  int looks = 0;               ///< 0: the verb's default
  double target_sigma_mm = 0.0;
  std::string dataset;         ///< calibrate
  std::string cost = "likelihood";  ///< calibrate --dataset: likelihood, poses, pixels or thesis
  std::string object, grasps = "host/config/grasps.yaml";
  std::vector<double> joints_rad, pose;  ///< pose: x, y, z in m, then qw, qx, qy, qz
  std::string posture;                   ///< move, park: one of the robot file's
  std::string then = "lift";             ///< grasp: lift | retreat | stay
  double speed = 1.0;                    ///< of every motion of the verb
  bool dry_run = false;                  ///< show the motion; nothing moves
  bool power_off = false;                ///< park: afterwards
  bool watch = false;                    ///< status: until interrupted, or for watch_s
  double watch_s = 0.0;
  std::string hand;            ///< open | close
  double force_permille = 500;
  std::vector<std::string> commission_joints;  ///< commission: none: all that are open
  std::string answers;                         ///< commission: file; empty: asks at the terminal
  double tolerance_deg = 0.2;                  ///< commission: of the angles that people measure
  std::vector<double> stiffness_permille;      ///< stiffness: one for all, or one a joint
  int marker_id = -1;          ///< print marker; -1: the hand's
  double marker_size_mm = 0.0; ///< 0: the hand's
  std::string dictionary, out, urdf, base_link, tip_link;
};

/// Does it; answers the exit code (0 done, 1 refused or failed, 2 bad input, 3 peer lost) after one line on stderr.
int run(const CommandLine& line);

}  // namespace armsight::host
