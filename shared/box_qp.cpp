#include "shared/box_qp.hpp"

#include <cassert>

namespace armsight {
namespace {

using HeldSet = std::array<bool, kMaxJoints>;

/// Where the free variables would go with the held ones fixed: N_ff x_f = g_f − N_fh x_h, by LDLᵀ. Written out, since for
/// so few variables of a number unknown to the compiler the loops are a third of the time of a matrix library's.
JointVector solve_free(const JointMatrix& N, const JointVector& g, const JointVector& x, const HeldSet& held) {
  const Eigen::Index n = g.size();
  std::array<Eigen::Index, kMaxJoints> free;
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    if (!held[static_cast<std::size_t>(i)]) free[count++] = i;

  std::array<std::array<double, kMaxJoints>, kMaxJoints> L;
  std::array<double, kMaxJoints> d_inverse, y;
  for (std::size_t r = 0; r < count; ++r) {
    double right = g[free[r]];
    for (Eigen::Index i = 0; static_cast<Eigen::Index>(count) < n && i < n; ++i)
      if (held[static_cast<std::size_t>(i)]) right -= N(free[r], i) * x[i];
    std::array<double, kMaxJoints> row;  // L·D of this row
    double d = N(free[r], free[r]);
    for (std::size_t c = 0; c < r; ++c) {
      double value = N(free[r], free[c]);
      for (std::size_t k = 0; k < c; ++k) value -= row[k] * L[c][k];
      row[c] = value;
      L[r][c] = value * d_inverse[c];
      d -= value * L[r][c];
      right -= L[r][c] * y[c];
    }
    d_inverse[r] = 1.0 / d;
    y[r] = right;
  }
  JointVector solution = x;
  for (std::size_t r = count; r-- > 0;) {
    double value = y[r] * d_inverse[r];
    for (std::size_t k = r + 1; k < count; ++k) value -= L[k][r] * solution[free[k]];
    solution[free[r]] = value;
  }
  return solution;
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
Eigen::Index most_unwilling(const JointMatrix& N, const JointVector& g, const JointVector& x, const JointVector& lower,
                            const JointVector& upper, const HeldSet& held) {
  double worst = 1e-14;
  Eigen::Index unwilling = -1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (!held[static_cast<std::size_t>(i)] || lower[i] >= upper[i]) continue;
    double slope = -g[i];
    for (Eigen::Index k = 0; k < x.size(); ++k) slope += N(k, i) * x[k];
    const double pull = x[i] <= lower[i] ? -slope : slope;  // > 0: the cost falls into the box
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
  // The free optimum, if it lies inside; else what is clamped of it makes a good first guess of the held set.
  const JointVector best = solve_free(N, g, JointVector::Zero(n), HeldSet{});
  JointVector x = best.cwiseMax(lower).cwiseMin(upper);
  HeldSet held{};
  bool is_inside = true;
  for (Eigen::Index i = 0; i < n; ++i) {
    held[static_cast<std::size_t>(i)] = !(x[i] == best[i]) || lower[i] >= upper[i];
    is_inside = is_inside && x[i] == best[i];
  }
  if (is_inside) return x;
  const int kMaxRounds = 64;  // each round adds or frees one bound; 8 variables never come near
  for (int round = 0; round < kMaxRounds; ++round) {
    const Eigen::Index blocking = walk(x, solve_free(N, g, x, held), lower, upper, held);
    if (blocking >= 0) {
      held[static_cast<std::size_t>(blocking)] = true;
      continue;
    }
    const Eigen::Index unwilling = most_unwilling(N, g, x, lower, upper, held);
    if (unwilling < 0) break;
    held[static_cast<std::size_t>(unwilling)] = false;
  }
  return x;
}

}  // namespace armsight
