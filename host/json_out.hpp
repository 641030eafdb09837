// The result files of the verbs (calibrate.json, adapt.json, move.json, grasp.json; of status: --out) as text. Keys
// carry their units; poses are {"p_m", "q_wxyz"}. Only json_out.cpp knows the JSON library.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/learn_arm.hpp"
#include "protocol/arm_link.pb.h"

namespace armsight::host {

struct CalibrateLookRecord {
  JointVector q_reading;
  std::int64_t arm_time_ns = 0;
  double reprojection_px = 0.0;
  std::string image;
};
struct CalibrateRecord {
  std::vector<CalibrateLookRecord> looks;
  ArmCalibration calibration;
  LearnedModel model;  ///< in force afterwards
  int attempts = 0;
  std::vector<std::string> images;
};
std::string to_json(const CalibrateRecord& record);

struct AdaptLookRecord {
  wire::FilterReport report;
  LearnedModel model;  ///< in force after the look
  std::string image;
};
struct AdaptRecord {
  LearnedModel before, after;
  std::vector<AdaptLookRecord> looks;
  int attempts = 0;
};
std::string to_json(const AdaptRecord& record);

struct MoveRecord {
  JointVector q_goal_real;       ///< zero size: a pose goal
  std::optional<Pose> T_B_G;
  wire::GoalStatus status;
  std::string state;
  LearnedModel model;
};
std::string to_json(const MoveRecord& record);

struct GraspRecord {
  std::string object, candidate;
  std::optional<Pose> T_C_O, T_O_G, T_B_G;
  LearnedModel model;
  std::string status;            ///< of the last motion
  std::int64_t arm_time_ns = 0;
  JointVector q_reading;
  std::string verdict;  ///< grasped | empty | refused | planned (a dry run)
  std::string then;     ///< with the object in the hand; empty: nothing was asked or nothing held
  std::string why;
  double hand_closure = 0.0, hand_effort_permille = 0.0;
  std::vector<std::string> images;
  std::string image_closed;      ///< of these: after the hand closed; empty where it did not
};
std::string to_json(const GraspRecord& record);

std::string to_json(const wire::ControllerStatistics& statistics);

}  // namespace armsight::host
