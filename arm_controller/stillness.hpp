// Does the arm stand still, and how fast is it? Least-squares slope of each joint over a window: one encoder count is
// 0.05 rad/s between two samples at 250 Hz, so differences of neighbours say nothing.
#pragma once

#include "arm_controller/joint_history.hpp"

namespace armsight::arm {

class StillnessWatch {
 public:
  static constexpr int kMaxWindow = 128;

  StillnessWatch(int joints, double still_speed_rad_s, double still_time_s, double period_s) noexcept;

  void push(const JointVector& q) noexcept;
  void reset() noexcept { count_ = next_ = still_samples_ = 0; }

  const JointVector& speed_rad_s() const noexcept { return speed_; }
  const JointVector& mean_rad() const noexcept { return mean_; }  ///< over the window
  bool is_still() const noexcept { return count_ == window_ && still_samples_ >= window_ / 2; }

 private:
  int window_;
  double period_s_, still_speed_;
  std::array<JointVector, kMaxWindow> ring_;
  int next_ = 0, count_ = 0, still_samples_ = 0;
  JointVector speed_, mean_;
};

}  // namespace armsight::arm
