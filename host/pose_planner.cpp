#include "host/pose_planner.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace armsight::host {
namespace {

constexpr int kTries = 40000;        // ≈ 2 000 visible ones of the default robot
constexpr int kCandidates = 600;
constexpr int kEnoughCandidates = 60;
constexpr int kExchangePasses = 3;
constexpr double kHiddenCosine = 0.98877;  // 8.6 degrees, 105 px at f = 700: half a can at working distance
constexpr double kHiddenDepth_m = 0.03;

double radical_inverse(int base, int i) {
  double value = 0.0, digit = 1.0;
  for (; i > 0; i /= base) {
    digit /= base;
    value += digit * (i % base);
  }
  return value;
}

double log_det(const StateMatrix& A) {
  const Eigen::LLT<StateMatrix> llt(A);
  if (llt.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  return 2.0 * llt.matrixLLT().diagonal().array().log().sum();
}

bool is_near_any(const JointVector& q, const std::vector<JointVector>& others, double distance_rad) {
  return std::any_of(others.begin(), others.end(), [&](const JointVector& other) {
    return (q - other).lpNorm<Eigen::Infinity>() < distance_rad;
  });
}

// Behind, or nearly in line with, a place where the marker was not seen although it should have been?
bool is_behind_any(const Vector3& p_C, const std::vector<Vector3>& hidden) {
  return std::any_of(hidden.begin(), hidden.end(), [&](const Vector3& other) {
    const double cosine = p_C.dot(other) / (p_C.norm() * other.norm());
    return cosine > kHiddenCosine && p_C.norm() > other.norm() - kHiddenDepth_m;
  });
}

// The view limits, drawn in by where the marker may be instead: one sigma of its place in the image and of its turn.
ViewLimits drawn_in(const PlanProblem& problem, const JointVector& q, const Pose& T_C_M, double sigmas) {
  const JointVector zero = JointVector::Zero(q.size());
  const MeasurementJacobian H = predict_hand_eye(problem.chain, problem.T_C_B, zero, q).H;
  const Matrix6 S = H * problem.P * H.transpose();
  const double position_sigma_m = std::sqrt(S.topLeftCorner<3, 3>().trace() / 3.0);
  const double rotation_sigma_rad = std::sqrt(S.bottomRightCorner<3, 3>().trace() / 3.0);
  ViewLimits limits = problem.limits;
  limits.image_margin_px += sigmas * position_sigma_m * problem.view.fx_px / std::max(T_C_M.p.z(), 0.1);
  limits.min_distance_m += sigmas * position_sigma_m;
  limits.max_distance_m -= sigmas * position_sigma_m;
  limits.min_tilt_rad += sigmas * rotation_sigma_rad;
  limits.max_tilt_rad -= sigmas * rotation_sigma_rad;
  return limits;
}

// One pass: every chosen look against every candidate; true if any was changed.
bool exchange_once(const std::vector<CandidateLook>& candidates, StateMatrix& total, std::vector<int>& chosen,
                   std::vector<bool>& is_used) {
  bool has_changed = false;
  for (int& slot : chosen) {
    const StateMatrix without = total - candidates[static_cast<std::size_t>(slot)].information;
    double best = log_det(total) + 1e-9;
    int best_index = slot;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      if (is_used[c]) continue;
      const double value = log_det(without + candidates[c].information);
      if (value > best) best = value, best_index = static_cast<int>(c);
    }
    if (best_index == slot) continue;
    is_used[static_cast<std::size_t>(slot)] = false;
    is_used[static_cast<std::size_t>(best_index)] = true;
    slot = best_index;
    total = without + candidates[static_cast<std::size_t>(slot)].information;
    has_changed = true;
  }
  return has_changed;
}

// Takes the candidate of the pool that adds most, again and again; returns the order in which they were taken.
std::vector<int> greedy(const std::vector<CandidateLook>& candidates, std::vector<int> pool, StateMatrix& total,
                        int count) {
  std::vector<int> taken;
  while (static_cast<int>(taken.size()) < count && !pool.empty()) {
    std::size_t best_slot = 0;
    double best = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < pool.size(); ++i) {
      const double value = log_det(total + candidates[static_cast<std::size_t>(pool[i])].information);
      if (value > best) best = value, best_slot = i;
    }
    taken.push_back(pool[best_slot]);
    total += candidates[static_cast<std::size_t>(pool[best_slot])].information;
    pool.erase(pool.begin() + static_cast<std::ptrdiff_t>(best_slot));
  }
  return taken;
}

}  // namespace

JointVector spread_posture(const JointVector& min_rad, const JointVector& max_rad, int i) {
  static constexpr std::array<int, kMaxJoints> kBases{2, 3, 5, 7, 11, 13, 17, 19};
  JointVector q(min_rad.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    q[j] = min_rad[j] + (max_rad[j] - min_rad[j]) * radical_inverse(kBases[static_cast<std::size_t>(j)], i + 1);
  }
  return q;
}

JointVector posture_near(const JointVector& q, double reach_rad, const JointVector& min_rad, const JointVector& max_rad,
                         int i) {
  const JointVector lower = (q.array() - reach_rad).max(min_rad.array()).min(max_rad.array());
  const JointVector upper = (q.array() + reach_rad).min(max_rad.array()).max(min_rad.array());
  return spread_posture(lower, upper, i);
}

bool is_too_near(const PlanProblem& problem, const JointVector& q_real) {
  constexpr double kUnsure_m = 0.01;  // offsets not learnt yet
  return clearance_at(problem.collision, problem.chain, q_real).distance_m <
         problem.collision.margin_m + kPlanSlack_m + kUnsure_m;
}

std::vector<CandidateLook> visible_postures(const PlanProblem& problem, int wanted, double unsure_sigmas,
                                            const std::vector<JointVector>& avoid, double min_distance_rad) {
  std::vector<CandidateLook> found;
  for (int i = 0; i < kTries && static_cast<int>(found.size()) < wanted; ++i) {
    const JointVector q = spread_posture(problem.min_rad, problem.max_rad, i);
    const Pose T_C_M = problem.T_C_B * forward_kinematics(problem.chain, q) * problem.T_H_M;
    if (!is_well_visible(problem.view, problem.limits, T_C_M, problem.marker_side_m)) continue;
    if (is_near_any(q, avoid, min_distance_rad) || is_behind_any(T_C_M.p, problem.hidden)) continue;
    if (is_too_near(problem, q)) continue;
    if (unsure_sigmas > 0.0) {
      const ViewLimits limits = drawn_in(problem, q, T_C_M, unsure_sigmas);
      if (!is_well_visible(problem.view, limits, T_C_M, problem.marker_side_m)) continue;
    }
    const std::optional<StateMatrix> information = look_information(
        problem.chain, problem.T_C_B, problem.T_H_M, problem.view, problem.marker_side_m, problem.noise, q);
    if (information) found.push_back({q, *information});
  }
  return found;
}

std::vector<int> choose_d_optimal(const std::vector<CandidateLook>& candidates, const StateMatrix& prior_information,
                                  int count) {
  std::vector<int> pool(candidates.size());
  for (std::size_t i = 0; i < pool.size(); ++i) pool[i] = static_cast<int>(i);
  StateMatrix total = prior_information;
  std::vector<int> chosen = greedy(candidates, pool, total, count);

  std::vector<bool> is_used(candidates.size(), false);
  for (const int c : chosen) is_used[static_cast<std::size_t>(c)] = true;
  for (int pass = 0; pass < kExchangePasses && exchange_once(candidates, total, chosen, is_used); ++pass) {
  }
  StateMatrix again = prior_information;  // the set is right; its order shall be the most informative first
  return greedy(candidates, chosen, again, count);
}

double log_det_information(const std::vector<CandidateLook>& candidates, const StateMatrix& prior_information,
                           const std::vector<int>& chosen) {
  StateMatrix total = prior_information;
  for (const int c : chosen) total += candidates[static_cast<std::size_t>(c)].information;
  return log_det(total);
}

std::vector<int> order_by_travel(const std::vector<CandidateLook>& candidates, std::vector<int> chosen,
                                 const JointVector& q_start) {
  JointVector at = q_start;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const auto travel = [&](int c) {
      return (candidates[static_cast<std::size_t>(c)].q_real - at).lpNorm<Eigen::Infinity>();
    };
    const auto nearest = std::min_element(chosen.begin() + static_cast<std::ptrdiff_t>(i), chosen.end(),
                                          [&](int a, int b) { return travel(a) < travel(b); });
    std::iter_swap(chosen.begin() + static_cast<std::ptrdiff_t>(i), nearest);
    at = candidates[static_cast<std::size_t>(chosen[i])].q_real;
  }
  return chosen;
}

std::vector<JointVector> plan_looks(const PlanProblem& problem, int count, const std::vector<JointVector>& avoid,
                                    const JointVector& q_start, bool shorten_travel) {
  std::vector<CandidateLook> candidates;
  for (const double sigmas : {1.5, 1.0, 0.5, 0.0}) {
    candidates = visible_postures(problem, kCandidates, sigmas, avoid);
    if (static_cast<int>(candidates.size()) >= std::max(kEnoughCandidates, 2 * count)) break;
  }
  const StateMatrix prior_information =
      problem.P.llt().solve(StateMatrix::Identity(problem.P.rows(), problem.P.cols()));
  std::vector<int> chosen = choose_d_optimal(candidates, prior_information, count);
  if (shorten_travel) chosen = order_by_travel(candidates, std::move(chosen), q_start);
  std::vector<JointVector> plan;
  for (const int c : chosen) plan.push_back(candidates[static_cast<std::size_t>(c)].q_real);
  return plan;
}

}  // namespace armsight::host
