#include "shared/redundancy.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

#include "shared/box_qp.hpp"

namespace armsight {
namespace {

constexpr double kNear_rad = 0.3;          // of a limit; of narrow joints a quarter of the range
constexpr double kSoundPoseManipulability = 0.05;
constexpr int kComfortSteps = 20, kTries = 5, kKeepingSteps = 6;
constexpr double kLongestStep_rad = 0.2;
constexpr double kLeastGain = 1e-4;
constexpr double kDifference_rad = 1e-5;
constexpr double kSamePose_m = 1e-11;      // and rad: the certificate of an exact answer stays exact

/// 0 … 1 of one joint, and its slope.
struct Nearness {
  double value = 0.0, slope_per_rad = 0.0;
};

Nearness nearness(double q, double min, double max) {
  const double near = std::min(kNear_rad, 0.25 * (max - min));
  if (!(near > 0.0)) return {};
  const double below = (min + near - q) / near, above = (q - max + near) / near;
  if (below > 0.0) return {below * below, -2.0 * below / near};
  if (above > 0.0) return {above * above, 2.0 * above / near};
  return {};
}

double limit_part(const JointVector& q, const JointVector& min, const JointVector& max) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < q.size(); ++i) sum += nearness(q[i], min[i], max[i]).value;
  return sum;
}

double singular_part(const SerialChain& chain, const Jacobian& J) {
  const double missing = std::max(0.0, 1.0 - pose_manipulability(chain, J) / kSoundPoseManipulability);
  return missing * missing;
}

JointVector gradient(const SerialChain& chain, const JointVector& q, const JointVector& min, const JointVector& max) {
  JointVector g = -2.0 * limit_relief(q, min, max);
  if (singular_part(chain, hand_kinematics(chain, q).J) == 0.0) return g;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    JointVector up = q, down = q;
    up[i] += kDifference_rad;
    down[i] -= kDifference_rad;
    g[i] += (singular_part(chain, hand_kinematics(chain, up).J) - singular_part(chain, hand_kinematics(chain, down).J)) /
            (2.0 * kDifference_rad);
  }
  return g;
}

/// What of a motion leaves the hand where it is: d − J⁺ J d.
JointVector without_hand(const Jacobian& J, const JointVector& d) {
  Matrix6 JJt = J * J.transpose();
  JJt.diagonal().array() += 1e-12;
  const Vector6 moved = J * d;
  return d - J.transpose() * JJt.ldlt().solve(moved);
}

/// Newton on the whole pose, least motion, within the limits. False: it cannot be kept from there.
bool restore(const SerialChain& chain, const Pose& T_B_H, JointVector& q, const JointVector& min,
             const JointVector& max) {
  for (int k = 0; k < kKeepingSteps; ++k) {
    const HandKinematics at = hand_kinematics(chain, q);
    const Vector6 e = pose_error(T_B_H, at.T_B_H);
    if (e.norm() < kSamePose_m) return true;
    JointMatrix N = at.J.transpose() * at.J;
    N.diagonal().array() += 1e-10;
    q += solve_box_qp(N, JointVector(at.J.transpose() * e), min - q, max - q);
  }
  return pose_error(T_B_H, forward_kinematics(chain, q)).norm() < kSamePose_m;
}

}  // namespace

double pose_manipulability(const SerialChain& chain, const Jacobian& J) {
  const double length_m = reach_m(chain) - chain.T_B_0.p.norm();
  if (chain.joint_count < 6 || !(length_m > 0.0)) return 0.0;
  Jacobian scaled = J;
  scaled.topRows<3>() /= length_m;
  const Matrix6 squared = scaled * scaled.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(squared, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[0]));
}

double discomfort(const SerialChain& chain, const JointVector& q, const JointVector& min_rad,
                  const JointVector& max_rad) {
  return limit_part(q, min_rad, max_rad) + singular_part(chain, hand_kinematics(chain, q).J);
}

JointVector limit_relief(const JointVector& q, const JointVector& min_rad, const JointVector& max_rad) {
  JointVector relief(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) relief[i] = -0.5 * nearness(q[i], min_rad[i], max_rad[i]).slope_per_rad;
  return relief;
}

JointVector most_comfortable(const SerialChain& chain, const JointVector& q_start, const JointVector& min_rad,
                             const JointVector& max_rad) {
  if (!is_redundant(chain)) return q_start;
  const Pose T_B_H = forward_kinematics(chain, q_start);
  JointVector q = q_start;
  double now = discomfort(chain, q, min_rad, max_rad);
  for (int k = 0; k < kComfortSteps && now > 0.0; ++k) {
    const JointVector downhill =
        without_hand(hand_kinematics(chain, q).J, -gradient(chain, q, min_rad, max_rad));
    const double longest = downhill.cwiseAbs().maxCoeff();
    if (!(longest > 1e-6)) break;
    double scale = kLongestStep_rad / longest, gain = 0.0;
    for (int halving = 0; halving < kTries && gain <= 0.0; ++halving, scale *= 0.4) {
      JointVector next = (q + scale * downhill).cwiseMax(min_rad).cwiseMin(max_rad);
      if (!restore(chain, T_B_H, next, min_rad, max_rad)) continue;
      const double then = discomfort(chain, next, min_rad, max_rad);
      if (then >= now) continue;
      gain = now - then;
      now = then;
      q = next;
    }
    if (gain < kLeastGain) break;
  }
  return q;
}

}  // namespace armsight
