#include "shared/pose_servo.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shared/box_qp.hpp"

namespace armsight {
namespace {

/// position_manipulability from which on no damping is needed.
constexpr double kSoundManipulability = 0.1;
/// Keeps the normal matrix definite where a joint moves nothing: 1e-5 m a radian against centimetres.
constexpr double kLeastDamping = 1e-5;

double damping_squared(double manipulability, double damping) {
  const double closeness = std::clamp(1.0 - manipulability / kSoundManipulability, 0.0, 1.0);
  return kLeastDamping * kLeastDamping + damping * damping * closeness * closeness;
}

}  // namespace

JointVector pose_servo_speeds(const SerialChain& chain, const JointVector& q_real, const Pose& T_B_G,
                              const JointVector& min_rad, const JointVector& max_rad,
                              const JointVector& max_speed_rad_s, double dt_s, const PoseServoOptions& options) {
  const JointVector still = JointVector::Zero(chain.joint_count);
  if (!q_real.allFinite() || !is_finite(T_B_G) || !(dt_s > 0.0)) return still;
  const HandKinematics hand = hand_kinematics(chain, q_real);
  Vector6 wanted = options.gain_per_s * pose_error(T_B_G, hand.T_B_H);
  Jacobian J = hand.J;
  J.bottomRows<3>() *= options.orientation_weight_m;
  wanted.tail<3>() *= options.orientation_weight_m;
  JointMatrix N = J.transpose() * J;
  N.diagonal().array() += damping_squared(position_manipulability(chain, q_real), options.damping);
  // Outside the limits the bounds ask for the way back, as fast as allowed.
  const JointVector lower = ((min_rad - q_real) / dt_s).cwiseMax(-max_speed_rad_s).cwiseMin(max_speed_rad_s);
  const JointVector upper = ((max_rad - q_real) / dt_s).cwiseMin(max_speed_rad_s).cwiseMax(-max_speed_rad_s);
  const JointVector speeds = solve_box_qp(N, J.transpose() * wanted, lower, upper);
  return speeds.allFinite() ? speeds : still;
}

}  // namespace armsight
