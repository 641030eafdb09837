// What a drive sees of a motion: differences of sampled set-points, which no limit may be exceeded by.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "shared/arm_model.hpp"

namespace armsight::test {

class SetpointJudge {
 public:
  static constexpr double kSlack = 1e-9;          // relative
  static constexpr double kRounding_rad = 4e-15;  // of a position, with the landing
  static constexpr double kSum_rad = 1e-12;       // of many: in a stop of thousands of steps

  SetpointJudge(const JointLimits& limits, double dt_s) : limits_(limits), dt_s_(dt_s) {}

  /// The next set-point; fails where one of the last three differences exceeds its limit.
  void take(const JointVector& q) {
    for (std::size_t k = 3; k > 0; --k) q_[k] = q_[k - 1];
    q_[0] = q;
    if (++count_ < 4) return;
    const double dt2 = dt_s_ * dt_s_, dt3 = dt2 * dt_s_;
    ASSERT_LE(excess((q_[0] - q_[1]) / dt_s_, limits_.max_speed_rad_s, 2 * kRounding_rad / dt_s_), 0.0) << "speed";
    const JointVector acceleration = (q_[0] - 2 * q_[1] + q_[2]) / dt2;
    ASSERT_LE(excess(acceleration, limits_.max_acceleration_rad_s2, 4 * kRounding_rad / dt2), 0.0) << "acceleration";
    const JointVector jerk = (q_[0] - 3 * q_[1] + 3 * q_[2] - q_[3]) / dt3;
    ASSERT_LE(excess(jerk, limits_.max_jerk_rad_s3, 8 * kRounding_rad / dt3), 0.0) << "jerk";
    ASSERT_LE((q - limits_.max_rad).maxCoeff(), kSum_rad) << "position";
    ASSERT_LE((limits_.min_rad - q).maxCoeff(), kSum_rad) << "position";
  }

 private:
  static double excess(const JointVector& value, const JointVector& limit, double rounding) {
    return (value.cwiseAbs() - (1 + kSlack) * limit).maxCoeff() - rounding;
  }

  JointLimits limits_;
  double dt_s_;
  std::array<JointVector, 4> q_;
  int count_ = 0;
};

}  // namespace armsight::test
