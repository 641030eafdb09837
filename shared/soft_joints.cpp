#include "shared/soft_joints.hpp"

#include <algorithm>

namespace armsight {
namespace {

constexpr double kIntegralGain_per_s = 4.0;
/// A tenth of what a joint of the default arm may do.
constexpr AxisLimits kBlend{.speed_rad_s = 0.05, .acceleration_rad_s2 = 0.4, .jerk_rad_s3 = 8.0};
constexpr double kIntegralLimit_rad = 0.25;  // half of a bend that is predicted by half

}  // namespace

bool SoftArm::has_springs() const {
  return std::any_of(springs.begin(), springs.begin() + chain.joint_count, [](const Spring& s) { return s.k_Nm > 0.0; });
}

bool SoftArm::has_masses() const {
  return std::any_of(links.begin(), links.begin() + chain.joint_count, [](const LinkMass& l) { return l.mass_kg > 0.0; });
}

SoftJoints::SoftJoints(const SoftArm& arm) : arm_(arm), full_(arm) {
  offset_ = feed_forward_ = integral_ = JointVector::Zero(arm.chain.joint_count);
}

void SoftJoints::reset() {
  integral_.setZero();
  has_beta_ = false;
}

void SoftJoints::set_preset_share(int joint, double share) {
  const auto k = static_cast<std::size_t>(joint);
  arm_.springs[k].preset_rad = share * full_.springs[k].preset_rad;
}

void SoftJoints::blend_beta(const JointVector& beta_rad, double dt_s) {
  for (Eigen::Index i = 0; i < beta_rad.size(); ++i) {
    AxisState& beta = beta_[static_cast<std::size_t>(i)];
    beta = has_beta_ ? step_to_place(beta, beta_rad[i], kBlend, dt_s) : AxisState{beta_rad[i], 0.0, 0.0};
  }
  has_beta_ = true;
}

void SoftJoints::step(const JointVector& q_wanted_rad, const JointVector& q_reading_rad, const JointVector& beta_rad,
                      bool is_resting, double dt_s) {
  if (!arm_.has_springs()) return;
  blend_beta(beta_rad, dt_s);
  JointVector q_real = q_wanted_rad;
  for (Eigen::Index i = 0; i < q_real.size(); ++i) q_real[i] += beta_[static_cast<std::size_t>(i)].q_rad;
  const JointVector torque = gravity_torque(arm_.chain, arm_.links, arm_.gravity_m_s2, q_real);
  for (int i = 0; i < arm_.chain.joint_count; ++i) {
    if (!arm_.is_soft(i)) continue;
    const Spring& spring = arm_.springs[static_cast<std::size_t>(i)];
    feed_forward_[i] = -spring_deflection(spring, torque[i]);
    if (is_resting) {
      // Anti-windup: no more than the limit, and nothing beyond the spring's stop.
      const double room = std::min(kIntegralLimit_rad, spring.max_deflection_rad);
      const double wanted = integral_[i] + kIntegralGain_per_s * dt_s * (q_wanted_rad[i] - q_reading_rad[i]);
      integral_[i] = std::clamp(std::clamp(wanted, -room, room), -spring.max_deflection_rad - feed_forward_[i],
                                spring.max_deflection_rad - feed_forward_[i]);
    }
    offset_[i] = std::clamp(feed_forward_[i] + integral_[i], -spring.max_deflection_rad, spring.max_deflection_rad);
  }
}

}  // namespace armsight
