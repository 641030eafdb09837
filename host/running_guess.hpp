// What is believed during Learn, look by look, from nothing but the first one: camera-base pose from a single look with
// offsets zero, then the filter with a prior as wide as Learn's, then, from six looks on, the batch solution.
// Good enough to plan the next look; the result of Learn does not depend on it. Pure.
#pragma once

#include <vector>

#include "host/learn_arm.hpp"
#include "shared/joint_offset_ekf.hpp"

namespace armsight::host {

class RunningGuess {
 public:
  RunningGuess(const ArmModel& arm, const EkfOptions& options);

  /// Takes the newest of `samples`. The first one sets the camera. A look that contradicts the guess twice running
  /// makes the newest one the new first: the first may have been the wrong planar solution.
  void take(const std::vector<LookSample>& samples);
  /// Replaces the guess by a batch solution.
  void take(const ArmCalibration& calibration);

  bool is_set() const { return is_set_; }
  const LearnedModel& model() const { return filter_.model(); }
  const StateMatrix& covariance() const { return filter_.covariance(); }
  /// Norm of the 1σ of the hand position at that reading.
  double hand_position_sigma_m(const JointVector& q_reading) const;
  Pose predict(const JointVector& q_reading) const;

 private:
  void start_from(const LookSample& sample);

  ArmModel arm_;
  JointOffsetEkf filter_;
  bool is_set_ = false;
  int contradictions_ = 0;
};

}  // namespace armsight::host
