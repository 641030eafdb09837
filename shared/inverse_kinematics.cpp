#include "shared/inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "shared/box_qp.hpp"
#include "shared/redundancy.hpp"
#include "shared/swivel_ik.hpp"

namespace armsight {
namespace {

/// 1/m²: how much more a metre of position weighs than a radian in a step along the postures of one position.
constexpr double kPositionPriority = 1e6;
constexpr int kRestoringSteps = 8;
constexpr double kExact_m = 1e-12;
constexpr double kNegligibleStep_rad = 1e-9, kNegligibleGain_rad = 1e-7;
/// Relative gain below which the first stage stops: it need only tell the basins apart.
constexpr double kStall = 1e-4;
/// A basin this much worse in orientation after the first stage than the best posture so far is not refined.
constexpr double kHopeless_rad = 0.3;
/// After so many equally good postures the nearest is chosen; an exact one cannot be bettered, a residual might be.
constexpr int kEnoughExact = 4, kEnoughAgreeing = 16;
/// Postures whose orientation errors differ by less count as equally good: the nearer to the seed wins.
constexpr double kSameOrientation_rad = 1e-4;
/// Of a redundant chain, in units of `discomfort`: so much less is worth a longer way.
constexpr double kSameComfort = 0.2;

struct Task {
  const SerialChain& chain;
  const Pose& T_B_G;
  JointVector min, max;  ///< margins taken off
  int max_evaluations;
  mutable int evaluations = 0;

  bool is_spent() const { return evaluations >= max_evaluations; }
};

struct State {
  JointVector q;
  Vector6 e;
  Jacobian J;
};

State evaluate(const Task& task, const JointVector& q) {
  ++task.evaluations;
  const HandKinematics hand = hand_kinematics(task.chain, q);
  return {q, pose_error(task.T_B_G, hand.T_B_H), hand.J};
}

double cost_of(const Vector6& e, double weight_m) {
  return e.head<3>().squaredNorm() + weight_m * weight_m * e.tail<3>().squaredNorm();
}

/// The step d with N d = g as far as the limits let it.
JointVector limited_step(const Task& task, const State& at, const JointMatrix& N, const JointVector& g) {
  return solve_box_qp(N, g, task.min - at.q, task.max - at.q);
}

/// Stage 1, Levenberg-Marquardt within the limits on |e_P|² + weight²|e_O|²: finds the basin.
State approach(const Task& task, State at, double weight_m, int iterations) {
  const double w2 = weight_m * weight_m;
  double damping = 1e-3;
  for (int k = 0; k < iterations && damping < 1e6 && !task.is_spent(); ++k) {
    const auto J_P = at.J.topRows<3>();
    const auto J_O = at.J.bottomRows<3>();
    JointMatrix N = J_P.transpose() * J_P + w2 * (J_O.transpose() * J_O);
    N.diagonal().array() += damping * N.trace() / static_cast<double>(N.rows()) + 1e-15;
    const JointVector g = J_P.transpose() * at.e.head<3>() + w2 * (J_O.transpose() * at.e.tail<3>());
    const JointVector d = limited_step(task, at, N, g);
    const State next = evaluate(task, at.q + d);
    const double gain = cost_of(at.e, weight_m) - cost_of(next.e, weight_m);
    const bool is_settled = gain < kStall * cost_of(at.e, weight_m) && damping < 1e-2;
    if (gain > 0.0) at = next;
    if ((gain >= 0.0 && is_settled) || d.cwiseAbs().maxCoeff() < kNegligibleStep_rad) break;
    damping = gain > 0.0 ? std::max(1e-12, damping * 0.1) : damping * 4.0;
  }
  return at;
}

/// Newton on the position alone, least motion, within the limits.
State restore_position(const Task& task, State at) {
  for (int k = 0; k < kRestoringSteps && at.e.head<3>().norm() > kExact_m; ++k) {
    JointMatrix N = at.J.topRows<3>().transpose() * at.J.topRows<3>();
    N.diagonal().array() += 1e-10;
    const JointVector g = at.J.topRows<3>().transpose() * at.e.head<3>();
    const State next = evaluate(task, at.q + limited_step(task, at, N, g));
    if (!(next.e.head<3>().norm() < at.e.head<3>().norm())) break;
    at = next;
  }
  return at;
}

/// Stage 2, position first: turns the hand along the postures that keep the position, to the least orientation error.
State turn_in_place(const Task& task, State at, double tolerance_m, int iterations) {
  double damping = 1e-4;
  for (int k = 0; k < iterations && damping < 1e4 && !task.is_spent(); ++k) {
    const auto J_P = at.J.topRows<3>();
    const auto J_O = at.J.bottomRows<3>();
    JointMatrix N = J_O.transpose() * J_O + kPositionPriority * (J_P.transpose() * J_P);
    N.diagonal().array() += damping;
    const JointVector d = limited_step(task, at, N, J_O.transpose() * at.e.tail<3>());
    if (d.cwiseAbs().maxCoeff() < kNegligibleStep_rad) break;
    const State next = restore_position(task, evaluate(task, at.q + d));
    const double gain = at.e.tail<3>().norm() - next.e.tail<3>().norm();
    const bool is_better = gain > 0.0 && next.e.head<3>().norm() <= tolerance_m;
    damping = is_better ? std::max(1e-9, damping * 0.1) : damping * 4.0;
    if (!is_better) continue;
    at = next;
    if (gain < kNegligibleGain_rad) break;
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

/// Leaves of the best in orientation those that end comfortably, each moved there.
void seek_comfort(const Task& task, std::vector<IkSolution>& found) {
  const auto by_orientation = [](const IkSolution& a, const IkSolution& b) {
    return a.orientation_error_rad < b.orientation_error_rad;
  };
  std::ranges::stable_sort(found, by_orientation);
  double least = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, IkSolution>> moved;
  for (const IkSolution& s : found) {
    if (s.orientation_error_rad > found.front().orientation_error_rad + kSameOrientation_rad) break;
    if (moved.size() == kEnoughExact) break;
    const State at = evaluate(task, most_comfortable(task.chain, s.q, task.min, task.max));
    const double left = discomfort(task.chain, at.q, task.min, task.max);
    moved.push_back({left, {at.q, at.e.head<3>().norm(), at.e.tail<3>().norm(), 0}});
    least = std::min(least, left);
  }
  found.clear();
  for (const auto& [left, s] : moved)
    if (left <= least + kSameComfort) found.push_back(s);
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
  if (const auto arm = swivel_arm(chain)) {
    return solve_swivel_ik(chain, *arm, min_rad + margin, max_rad - margin, T_B_G, seed, options.position_tolerance_m);
  }
  const Task task{chain, T_B_G, min_rad + margin, max_rad - margin, options.max_evaluations};
  std::vector<IkSolution> found;
  double least = std::numeric_limits<double>::infinity();
  int agreeing = 0;
  for (int k = 0; k < 2 * std::max(1, options.starts) && !task.is_spent(); ++k) {
    State at = evaluate(task, k < 2 ? JointVector(seed.cwiseMax(task.min).cwiseMin(task.max)) : start_posture(task, k / 2));
    // Each start twice: position first, which keeps a folded elbow, and by the weighted way, which crosses more basins.
    if (k % 2 == 1) at = approach(task, at, options.orientation_weight_m, options.iterations);
    if (k % 2 == 1 && at.e.tail<3>().norm() > least + kHopeless_rad) continue;
    at = restore_position(task, at);
    if (!(at.e.head<3>().norm() <= options.position_tolerance_m)) continue;
    at = turn_in_place(task, at, options.position_tolerance_m, options.iterations);
    const double position_error = at.e.head<3>().norm(), orientation_error = at.e.tail<3>().norm();
    found.push_back({at.q, position_error, orientation_error, 0});
    if (orientation_error < least - kSameOrientation_rad) agreeing = 0;
    if (orientation_error < least + kSameOrientation_rad) ++agreeing;
    least = std::min(least, orientation_error);
    if (agreeing >= (least < kSameOrientation_rad ? kEnoughExact : kEnoughAgreeing)) break;
  }
  if (options.seeks_comfort && is_redundant(chain)) seek_comfort(task, found);
  std::optional<IkSolution> best = best_of(found, seed);
  if (best) best->evaluations = task.evaluations;
  return best;
}

}  // namespace armsight
