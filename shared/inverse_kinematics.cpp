#include "shared/inverse_kinematics.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "shared/box_qp.hpp"

namespace armsight {
namespace {

/// Orientation weight of the second stage: the position error it leaves is (weight)² · rad/m, below a micrometre.
constexpr double kPriorityWeight_m = 1e-3;
constexpr int kPolishSteps = 8;
constexpr double kNegligibleStep_rad = 1e-9;
/// Gain below which the two stages stop; the first need only tell the basins apart.
constexpr double kRoughStall = 1e-4, kFineStall = 1e-9;
/// A basin this much worse in orientation after the first stage than the best posture so far is not refined.
constexpr double kHopeless_rad = 0.3;
/// After so many equally good postures the nearest is chosen; an exact one cannot be bettered, a residual might be.
constexpr int kEnoughExact = 4, kEnoughAgreeing = 16;
/// Postures whose orientation errors differ by less count as equally good: the nearer to the seed wins.
constexpr double kSameOrientation_rad = 1e-4;

struct Task {
  const SerialChain& chain;
  const Pose& T_B_G;
  JointVector min, max;  ///< margins taken off
};

struct State {
  JointVector q;
  Vector6 e;
  Jacobian J;
};

State evaluate(const Task& task, const JointVector& q) {
  const HandKinematics hand = hand_kinematics(task.chain, q);
  return {q, pose_error(task.T_B_G, hand.T_B_H), hand.J};
}

double cost_of(const Vector6& e, double weight_m) {
  return e.head<3>().squaredNorm() + weight_m * weight_m * e.tail<3>().squaredNorm();
}

bool leaves(const Task& task, const JointVector& q, const JointVector& d, Eigen::Index i) {
  return (q[i] <= task.min[i] && d[i] < 0.0) || (q[i] >= task.max[i] && d[i] > 0.0);
}

/// Takes joint i out of the equations N d = g.
void hold(JointMatrix& N, JointVector& g, Eigen::Index i) {
  N.row(i).setZero();
  N.col(i).setZero();
  N(i, i) = 1.0;
  g[i] = 0.0;
}

/// Damped step that keeps joints at their limits from pushing outwards.
JointVector limited_step(const Task& task, const State& at, JointMatrix N, JointVector g) {
  JointVector d = g;
  for (Eigen::Index round = 0; round <= g.size(); ++round) {
    d = N.llt().solve(g);
    bool is_inside = true;
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      if (!leaves(task, at.q, d, i)) continue;
      hold(N, g, i);
      is_inside = false;
    }
    if (is_inside) break;
  }
  return (at.q + d).cwiseMax(task.min).cwiseMin(task.max) - at.q;
}

/// Levenberg-Marquardt within the limits on |e_P|² + weight²|e_O|², until a good step gains less than `stall` of it.
State descend(const Task& task, State at, double weight_m, double stall, int iterations) {
  double cost = cost_of(at.e, weight_m);
  double damping = 1e-3;
  for (int k = 0; k < iterations && damping < 1e6; ++k) {
    const auto J_P = at.J.topRows<3>();
    const auto J_O = at.J.bottomRows<3>();
    const double w2 = weight_m * weight_m;
    JointMatrix N = J_P.transpose() * J_P + w2 * (J_O.transpose() * J_O);
    const JointVector g = J_P.transpose() * at.e.head<3>() + w2 * (J_O.transpose() * at.e.tail<3>());
    N.diagonal().array() += damping * N.trace() / static_cast<double>(N.rows()) + 1e-15;
    const JointVector d = limited_step(task, at, N, g);
    const State next = evaluate(task, at.q + d);
    const double next_cost = cost_of(next.e, weight_m);
    const bool is_small = d.cwiseAbs().maxCoeff() < kNegligibleStep_rad;
    if (next_cost < cost) {
      const bool is_stalled = cost - next_cost < stall * cost && damping < 1e-2;
      at = next;
      cost = next_cost;
      damping = std::max(1e-12, damping * 0.1);
      if (is_stalled) break;
    } else {
      damping *= 4.0;
    }
    if (is_small) break;
  }
  return at;
}

/// Newton on the position alone, least motion, so that the certificate's position error is rounding.
State polish_position(const Task& task, State at) {
  for (int k = 0; k < kPolishSteps && at.e.head<3>().norm() > 1e-13; ++k) {
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxJoints> J_P = at.J.topRows<3>();
    for (Eigen::Index i = 0; i < at.q.size(); ++i) {
      if (at.q[i] <= task.min[i] || at.q[i] >= task.max[i]) J_P.col(i).setZero();
    }
    Matrix3 S = J_P * J_P.transpose();
    S.diagonal().array() += 1e-12;
    const JointVector d = J_P.transpose() * S.llt().solve(at.e.head<3>());
    const State next = evaluate(task, (at.q + d).cwiseMax(task.min).cwiseMin(task.max));
    if (!(next.e.head<3>().norm() < at.e.head<3>().norm())) break;
    at = next;
  }
  return at;
}

/// Start k ≥ 1: Weyl's sequence on roots of the generalised golden ratio, evenly spread in any number of joints.
JointVector start_posture(const Task& task, int k) {
  const auto n = task.min.size();
  double ratio = 1.5;
  for (int i = 0; i < 40; ++i) ratio = std::pow(1.0 + ratio, 1.0 / static_cast<double>(n + 1));
  JointVector q(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double turns = 0.5 + k * std::pow(ratio, -static_cast<double>(i + 1));
    q[i] = task.min[i] + (task.max[i] - task.min[i]) * (turns - std::floor(turns));
  }
  return q;
}

/// The best of the candidates: least orientation error, then nearest to the seed.
std::optional<IkSolution> best_of(const std::vector<IkSolution>& found, const JointVector& seed) {
  double least = std::numeric_limits<double>::infinity();
  for (const IkSolution& s : found) least = std::min(least, s.orientation_error_rad);
  std::optional<IkSolution> best;
  for (const IkSolution& s : found) {
    if (s.orientation_error_rad > least + kSameOrientation_rad) continue;
    if (!best || (s.q - seed).squaredNorm() < (best->q - seed).squaredNorm()) best = s;
  }
  return best;
}

bool is_well_posed(const SerialChain& chain, const JointVector& min_rad, const JointVector& max_rad,
                   const Pose& T_B_G, const JointVector& seed) {
  const auto n = chain.joint_count;
  return n > 0 && min_rad.size() == n && max_rad.size() == n && seed.size() == n && min_rad.allFinite() &&
         max_rad.allFinite() && seed.allFinite() && (max_rad - min_rad).minCoeff() >= 0.0 && is_finite(T_B_G) &&
         is_rotation(T_B_G.R);
}

}  // namespace

std::optional<IkSolution> solve_ik(const SerialChain& chain, const JointVector& min_rad, const JointVector& max_rad,
                                   const Pose& T_B_G, const JointVector& seed, const IkOptions& options) {
  if (!is_well_posed(chain, min_rad, max_rad, T_B_G, seed)) return std::nullopt;
  if (T_B_G.p.norm() > reach_m(chain) + options.position_tolerance_m) return std::nullopt;
  const JointVector margin = (0.25 * (max_rad - min_rad)).cwiseMin(options.limit_margin_rad);
  const Task task{chain, T_B_G, min_rad + margin, max_rad - margin};
  std::vector<IkSolution> found;
  double least = std::numeric_limits<double>::infinity();
  int agreeing = 0;
  for (int k = 0; k < std::max(1, options.starts); ++k) {
    const JointVector start = k == 0 ? JointVector(seed.cwiseMax(task.min).cwiseMin(task.max)) : start_posture(task, k);
    State at = descend(task, evaluate(task, start), options.orientation_weight_m, kRoughStall, options.iterations);
    if (at.e.tail<3>().norm() > least + kHopeless_rad) continue;
    at = polish_position(task, descend(task, at, kPriorityWeight_m, kFineStall, options.iterations));
    const double position_error = at.e.head<3>().norm(), orientation_error = at.e.tail<3>().norm();
    if (position_error > options.position_tolerance_m) continue;
    found.push_back({at.q, position_error, orientation_error});
    if (orientation_error < least - kSameOrientation_rad) agreeing = 0;
    if (orientation_error < least + kSameOrientation_rad) ++agreeing;
    least = std::min(least, orientation_error);
    if (agreeing >= (least < kSameOrientation_rad ? kEnoughExact : kEnoughAgreeing)) break;
  }
  return best_of(found, seed);
}

}  // namespace armsight
