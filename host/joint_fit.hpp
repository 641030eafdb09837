// What a joint's drive has to be told, from what an operator saw at three places: `host commission`. Angles in rad;
// "reading" is what the robot file makes of the drive's count, "true" what the operator measured.
//
//   true = slope · (reading − reading_here) + true_here      slope < 0: the sign is wrong, |slope| ≠ 1: the scale
#pragma once

#include <string>
#include <variant>

#include "protocol/config.hpp"

namespace armsight::host {

/// What the operator says.
struct JointAnswers {
  double here_rad = 0.0, up_rad = 0.0, down_rad = 0.0;  ///< true angles: at first, after each turn by 2°
  bool turned_positive = false;                         ///< on the way up
  double free_min_rad = 0.0, free_max_rad = 0.0;        ///< how far the mechanics and cables let it turn
};
struct JointReadings {
  double here_rad = 0.0, up_rad = 0.0, down_rad = 0.0;
};

struct JointFit {
  int sign = 1;
  double counts_per_turn = 0.0, gear = 1.0, zero_rad = 0.0;
  double scale = 1.0;        ///< true over reading; 1 where the measurement cannot tell it from 1
  double scale_sigma = 0.0;  ///< of the measurement, ±
};

/// tolerance_rad: how exactly the operator measures. A text instead of a fit: which answer contradicts what.
std::variant<JointFit, std::string> fit_joint(const JointAnswers& answers, const JointReadings& readings,
                                              const DriveConfig& drive, double min_rad, double max_rad,
                                              double tolerance_rad);

}  // namespace armsight::host
