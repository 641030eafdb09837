#include "shared/box_qp.hpp"

#include <Eigen/Cholesky>
#include <cassert>

namespace armsight {
namespace {

using HeldSet = std::array<bool, kMaxJoints>;

/// Where the free variables would go with the held ones fixed.
JointVector solve_free(JointMatrix N, JointVector g, const JointVector& x, const HeldSet& held) {
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (!held[static_cast<std::size_t>(i)]) continue;
    g -= N.col(i) * x[i];
    N.row(i).setZero();
    N.col(i).setZero();
    N(i, i) = 1.0;
    g[i] = x[i];
  }
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (held[static_cast<std::size_t>(i)]) g[i] = x[i];  // later held columns disturbed it
  }
  return N.llt().solve(g);
}

/// Walks from x to `goal` up to the first bound; returns the variable that met it, −1 where none did.
Eigen::Index walk(JointVector& x, const JointVector& goal, const JointVector& lower, const JointVector& upper,
                  const HeldSet& held) {
  double fraction = 1.0;
  Eigen::Index blocking = -1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (held[static_cast<std::size_t>(i)]) continue;
    const double bound = goal[i] > upper[i] ? upper[i] : lower[i];
    if (goal[i] <= upper[i] && goal[i] >= lower[i]) continue;
    const double reach = (bound - x[i]) / (goal[i] - x[i]);
    if (reach >= fraction) continue;
    fraction = reach;
    blocking = i;
  }
  x += fraction * (goal - x);
  if (blocking >= 0) x[blocking] = goal[blocking] > upper[blocking] ? upper[blocking] : lower[blocking];
  return blocking;
}

/// The held variable whose bound pushes the wrong way most, −1 at the optimum.
Eigen::Index most_unwilling(const JointVector& slope, const JointVector& x, const JointVector& lower,
                            const JointVector& upper, const HeldSet& held) {
  double worst = 1e-14;
  Eigen::Index unwilling = -1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (!held[static_cast<std::size_t>(i)] || lower[i] >= upper[i]) continue;
    const double pull = x[i] <= lower[i] ? -slope[i] : slope[i];  // > 0: the cost falls into the box
    if (pull <= worst) continue;
    worst = pull;
    unwilling = i;
  }
  return unwilling;
}

}  // namespace

JointVector solve_box_qp(const JointMatrix& N, const JointVector& g, const JointVector& lower,
                         const JointVector& upper) {
  const Eigen::Index n = g.size();
  assert(N.rows() == n && lower.size() == n && upper.size() == n);
  JointVector x = JointVector::Zero(n).cwiseMax(lower).cwiseMin(upper);
  HeldSet held{};
  for (Eigen::Index i = 0; i < n; ++i) {
    held[static_cast<std::size_t>(i)] = x[i] != 0.0 || lower[i] >= upper[i];
  }
  const int kMaxRounds = 64;  // each round adds or frees one bound; 8 variables never come near
  for (int round = 0; round < kMaxRounds; ++round) {
    const Eigen::Index blocking = walk(x, solve_free(N, g, x, held), lower, upper, held);
    if (blocking >= 0) {
      held[static_cast<std::size_t>(blocking)] = true;
      continue;
    }
    const Eigen::Index unwilling = most_unwilling(N * x - g, x, lower, upper, held);
    if (unwilling < 0) break;
    held[static_cast<std::size_t>(unwilling)] = false;
  }
  return x;
}

}  // namespace armsight
