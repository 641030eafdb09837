// Which targets do soft joints need so that their links stand where they should? The drive turns one end of a spring
// (the equilibrium), the encoder sees the other (the link), gravity bends what lies between. Feed-forward of the bend that
// the description predicts, and a slow integral on the link's error for what it predicts wrongly: "control action" of
// fig. 7.4, specification F-S4, §4.4. rad, N·m, s. No heap, no throw.
#pragma once

#include <array>

#include "shared/gravity.hpp"
#include "shared/jerk_profile.hpp"
#include "shared/spring.hpp"

namespace armsight {

struct SoftArm {
  SerialChain chain;
  LinkMasses links;
  Vector3 gravity_m_s2 = Vector3::Zero();  ///< in B
  std::array<Spring, kMaxJoints> springs{};  ///< k_Nm = 0: a stiff joint

  bool is_soft(int joint) const { return springs[static_cast<std::size_t>(joint)].k_Nm > 0.0; }
  bool has_springs() const;
  bool has_masses() const;
};

class SoftJoints {
 public:
  explicit SoftJoints(const SoftArm& arm);

  /// Forgets the integral, and takes the next step's offsets at once.
  void reset();
  /// One step of dt_s. q_wanted_rad, q_reading_rad: link angles as the encoders count, beta_rad on top is the real angle
  /// where gravity acts: revised offsets come in within a second or two, jerk-limited like a motion of the tenth part,
  /// so that nothing jumps. The integral moves only while `is_resting`: a joint under way is behind its set-point for
  /// reasons that pass.
  void step(const JointVector& q_wanted_rad, const JointVector& q_reading_rad, const JointVector& beta_rad,
            bool is_resting, double dt_s);
  /// Share of the description's preset that a spring has now, 0 … 1.
  void set_preset_share(int joint, double share);
  /// Equilibrium − wanted link angle, what the drives' targets are moved by; 0 for stiff joints. Inside ± the springs'
  /// max_deflection_rad.
  const JointVector& offset_rad() const { return offset_; }
  /// As described.
  const SoftArm& arm() const { return full_; }
  const JointVector& feed_forward_rad() const { return feed_forward_; }
  const JointVector& integral_rad() const { return integral_; }

 private:
  void blend_beta(const JointVector& beta_rad, double dt_s);

  SoftArm arm_, full_;  ///< springs as they are now, and as described
  JointVector offset_, feed_forward_, integral_;
  std::array<AxisState, kMaxJoints> beta_;  ///< on its way to the offsets in force
  bool has_beta_ = false;
};

}  // namespace armsight
