#include "arm_controller/stillness.hpp"

#include <algorithm>
#include <cmath>

namespace armsight::arm {

StillnessWatch::StillnessWatch(int joints, double still_speed_rad_s, double still_time_s, double period_s) noexcept
    : window_(std::clamp(static_cast<int>(std::lround(still_time_s / period_s)), 4, kMaxWindow)),
      period_s_(period_s), still_speed_(still_speed_rad_s), speed_(JointVector::Zero(joints)),
      mean_(JointVector::Zero(joints)) {}

void StillnessWatch::push(const JointVector& q) noexcept {
  ring_[static_cast<std::size_t>(next_)] = q;
  next_ = (next_ + 1) % window_;
  count_ = std::min(count_ + 1, window_);
  JointVector sum = JointVector::Zero(q.size()), moment = JointVector::Zero(q.size());
  const double centre = 0.5 * (count_ - 1);
  for (int i = 0; i < count_; ++i) {
    const JointVector& sample = ring_[static_cast<std::size_t>((next_ - count_ + i + window_) % window_)];
    sum += sample;
    moment += (i - centre) * sample;
  }
  mean_ = sum / count_;
  const double n = count_;
  // Σ(i − centre)² = n(n² − 1)/12
  speed_ = count_ > 1 ? JointVector(moment * (12.0 / (n * (n * n - 1.0) * period_s_))) : JointVector(0.0 * sum);
  const bool is_slow = speed_.cwiseAbs().maxCoeff() < still_speed_;
  still_samples_ = is_slow ? still_samples_ + 1 : 0;
}

}  // namespace armsight::arm
