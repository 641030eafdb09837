// What is true and nobody else knows: drawn from the seed by the figures of a noise set (specification §7.1).
#pragma once

#include "protocol/config.hpp"
#include "tools/sim/noise.hpp"
#include "tools/sim/scene.hpp"
#include "tools/sim/smooth_error.hpp"

namespace armsight::sim {

enum class CameraMount { kNear, kAnywhere };

struct Truth {
  std::uint64_t seed = 0;
  NoiseSet noise = NoiseSet::kNominal;
  SerialChain chain;             ///< with link errors
  Pose T_H_M;
  Pose T_C_B;
  JointVector beta;              ///< q_real = q_reading + beta
  Pose T_B_O;                    ///< where the object stands at first
  JointVector start_rad;         ///< real angles
  std::array<SmoothError, kMaxJoints> encoder_error;   ///< of the real angle; the reading lacks it
  std::array<SmoothError, kMaxJoints> servo_residual;  ///< where a drive settles beside its target
};

Truth make_truth(const RobotConfig& robot, const Scene& scene, NoiseSet noise, CameraMount mount, std::uint64_t seed);

/// The drift between Learn and Adapt: the camera turns about itself and shifts, the joints' zeros move.
void inject_drift(Truth& truth);

/// Camera beside its nominal mount: shift and turn up to the noise set's figures.
Pose near_mount(const Pose& nominal_T_C_B, const NoiseFigures& figures, std::uint64_t seed);
/// A camera somewhere else from which palm and object can be seen.
Pose mount_anywhere(const RobotConfig& robot, const Scene& scene, const Pose& T_B_O, std::uint64_t seed);

}  // namespace armsight::sim
