#include "shared/pose_servo.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shared/box_qp.hpp"
#include "shared/redundancy.hpp"

namespace armsight {
namespace {

/// position_manipulability from which on no damping is needed.
constexpr double kSoundManipulability = 0.1;
/// Keeps the normal matrix definite where a joint moves nothing: 1e-5 m a radian against centimetres.
constexpr double kLeastDamping = 1e-5;
/// Of a redundant chain: 1e-3 m a rad/s, so that its relief moves the hand by less than the tolerances.
constexpr double kRelief = 1e-3, kReliefGain_rad_s = 0.05;

double damping_squared(const SerialChain& chain, const Jacobian& J, double damping) {
  const double manipulability = position_manipulability(chain, J, kSoundManipulability);
  const double closeness = std::clamp(1.0 - manipulability / kSoundManipulability, 0.0, 1.0);
  return kLeastDamping * kLeastDamping + damping * damping * closeness * closeness;
}

}  // namespace

JointVector pose_servo_speeds(const SerialChain& chain, const JointVector& q_real, const Pose& T_B_G,
                              const JointVector& min_rad, const JointVector& max_rad,
                              const JointVector& max_speed_rad_s, double dt_s, const PoseServoOptions& options) {
  if (!q_real.allFinite() || !is_finite(T_B_G) || !(dt_s > 0.0)) return JointVector::Zero(chain.joint_count);
  const HandKinematics hand = hand_kinematics(chain, q_real);
  const Vector6 wanted = options.gain_per_s * pose_error(T_B_G, hand.T_B_H);
  // The normal equations of min |W (J q̇ − wanted)|², W = diag(1, 1, 1, w, w, w).
  Vector6 weight = Vector6::Ones();
  weight.tail<3>().setConstant(options.orientation_weight_m * options.orientation_weight_m);
  const Eigen::Index n = chain.joint_count;
  JointMatrix N(n, n);
  JointVector g(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector6 column = weight.cwiseProduct(hand.J.col(i));
    g[i] = column.dot(wanted);
    for (Eigen::Index k = 0; k <= i; ++k) N(i, k) = N(k, i) = column.dot(hand.J.col(k));
  }
  N.diagonal().array() += damping_squared(chain, hand.J, options.damping);
  if (is_redundant(chain)) {  // what the hand leaves free goes away from the limits
    N.diagonal().array() += kRelief * kRelief;
    g += kRelief * kRelief * kReliefGain_rad_s * limit_relief(q_real, min_rad, max_rad);
  }
  const double per_dt = 1.0 / dt_s;
  JointVector lower(n), upper(n);
  for (Eigen::Index i = 0; i < n; ++i) {  // outside the limits the bounds ask for the way back, as fast as allowed
    const double most = max_speed_rad_s[i];
    lower[i] = std::min(std::max((min_rad[i] - q_real[i]) * per_dt, -most), most);
    upper[i] = std::max(std::min((max_rad[i] - q_real[i]) * per_dt, most), -most);
  }
  JointVector speeds = solve_box_qp(N, g, lower, upper);
  if (!speeds.allFinite()) speeds.setZero();
  return speeds;
}

}  // namespace armsight
