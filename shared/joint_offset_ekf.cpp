#include "shared/joint_offset_ekf.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace armsight {
namespace {

/// χ² units below which another inner step is not worth taking.
constexpr double kConverged = 1e-9;
constexpr double kFirstDamping = 1.0;
constexpr double kDampingFactor = 10.0;

using StateBy6 = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxState, 6>;

/// A B, column by column: for matrices of about 11 rows faster than what Eigen picks for sizes unknown to the compiler.
template <class Product, class A, class B>
Product product(const A& a, const B& b) {
  Product c = Product::Zero(a.rows(), b.cols());
  for (Eigen::Index j = 0; j < b.cols(); ++j)
    for (Eigen::Index k = 0; k < a.cols(); ++k) c.col(j) += b(k, j) * a.col(k);
  return c;
}

/// What one hypothesis is judged on: prior at `model` with covariance P, the look T_C_H at q with covariance R.
struct Problem {
  const SerialChain& chain;
  const LearnedModel& model;
  const StateMatrix& P;
  const JointVector& q;
  const Matrix6& R;
  Eigen::LLT<Matrix6> R_llt;
};

/// A trial correction x = P a (a spares the inverse of P) and all that follows from it.
struct Trial {
  StateVector x, a;
  LearnedModel model;     ///< x folded in
  Vector6 e;              ///< pose_error(look, prediction)
  MeasurementJacobian H;  ///< about the folded model, in its own base frame
  double cost = 0.0;      ///< xᵀP⁻¹x + eᵀR⁻¹e
};

/// The best trial found.
struct Optimum {
  Trial trial;
  int iterations = 0;
  bool is_sound = false;
};

Trial evaluate(const Problem& problem, const Pose& T_C_H, const StateVector& x, const StateVector& a) {
  Trial trial{x, a, apply_error_state(problem.model, x), {}, {}, 0.0};
  const HandEyePrediction prediction =
      predict_hand_eye(problem.chain, trial.model.T_C_B, trial.model.beta, problem.q);
  trial.e = pose_error(T_C_H, prediction.T_C_H);  // (5.17), (5.18)
  trial.H = prediction.H;                         // (5.15)
  trial.cost = x.dot(a) + trial.e.dot(problem.R_llt.solve(trial.e));
  return trial;
}

/// −∂e/∂x at a trial. x counts from the prior's frame, so the columns of H turn back by exp(w) and J_r(w); the log adds
/// J_r⁻¹(e_O). Only the optimum is sought with it: the covariance takes H itself (joseph_update).
MeasurementJacobian residual_jacobian(const Trial& trial) {
  const Vector3 w = trial.x.segment<3>(kErrorW);
  MeasurementJacobian G = trial.H;
  G.middleCols<3>(kErrorV) = trial.H.middleCols<3>(kErrorV) * so3_exp(w).transpose();
  G.middleCols<3>(kErrorW) = trial.H.middleCols<3>(kErrorW) * so3_left_jacobian(-w);
  const Matrix3 log_slope = so3_left_jacobian(-trial.e.tail<3>()).inverse();
  for (Eigen::Index i = 0; i < G.cols(); ++i) G.col(i).tail<3>() = log_slope * G.col(i).tail<3>();
  return G;
}

/// Gauss-Newton step from `from`, Levenberg-damped in the metric of the prior: (5.12) and (5.14) with P/(1 + damping).
bool try_step(const Problem& problem, const Pose& T_C_H, const Trial& from, double damping, Trial& to) {
  const double scale = 1.0 / (1.0 + damping);
  const MeasurementJacobian G = residual_jacobian(from);
  const StateBy6 PGt = product<StateBy6>(problem.P, G.transpose());
  const Matrix6 S = scale * product<Matrix6>(G, PGt) + problem.R;
  const Eigen::LLT<Matrix6> S_llt(S);
  if (S_llt.info() != Eigen::Success) return false;
  const Vector6 s = S_llt.solve(from.e + scale * (G * from.x));
  const StateVector x = from.x + scale * (PGt * s - from.x);
  const StateVector a = from.a + scale * (G.transpose() * s - from.a);
  to = evaluate(problem, T_C_H, x, a);
  return std::isfinite(to.cost);
}

/// Least cost within max_iterations inner steps: an uphill step is refused and tried again shorter.
Optimum optimise(const Problem& problem, const Pose& T_C_H, int max_iterations) {
  const StateVector zero = StateVector::Zero(problem.P.rows());
  Optimum best{evaluate(problem, T_C_H, zero, zero), 0, false};
  if (!std::isfinite(best.trial.cost)) return best;
  best.is_sound = true;
  double damping = 0.0;
  Trial next;
  while (best.iterations < max_iterations) {
    ++best.iterations;
    if (!try_step(problem, T_C_H, best.trial, damping, next)) return {best.trial, best.iterations, false};
    const double gain = best.trial.cost - next.cost;
    if (gain > 0.0) {
      best.trial = next;
      damping = damping > kFirstDamping ? damping / kDampingFactor : 0.0;
    } else {
      damping = std::max(kFirstDamping, damping * kDampingFactor);
    }
    if (std::abs(gain) < kConverged) break;
  }
  return best;
}

struct Choice {
  Optimum best;
  bool is_second = false;
};

/// The planar solution that explains the look at the least cost.
Choice choose(const Problem& problem, const HandPoseMeasurement& z, int max_iterations) {
  Choice chosen{optimise(problem, z.T_C_H, max_iterations), false};
  if (!z.has_second) return chosen;
  const Optimum other = optimise(problem, z.T_C_H_second, max_iterations);
  const bool is_better = other.is_sound && (!chosen.best.is_sound || other.trial.cost < chosen.best.trial.cost);
  return is_better ? Choice{other, true} : chosen;
}

struct Posterior {
  StateMatrix P;
  double gain_norm = 0.0;
  bool is_sound = false;
};

/// (5.13), (5.14) at the optimum. P is carried there unchanged and meets H in that point's own base frame, where the
/// gauge (w_z, β1) = (1, −1) is a null direction of every H: no look ever informs it (§5.1).
Posterior joseph_update(const StateMatrix& P, const MeasurementJacobian& H, const Matrix6& R) {
  const StateBy6 PHt = product<StateBy6>(P, H.transpose());
  const Matrix6 S = product<Matrix6>(H, PHt) + R;
  const Eigen::LLT<Matrix6> S_llt(S);
  const StateBy6 K = S_llt.solve(PHt.transpose()).transpose();
  // (I − KH) P (I − KH)ᵀ + K R Kᵀ multiplied out, which holds for every K: P − K HP − (PHᵀ − K S) Kᵀ. As a sum of
  // squares it takes 0.4 µs longer and keeps P no longer positive: both last to condition numbers of about 1e12.
  const StateBy6 rest = PHt - product<StateBy6>(K, S);
  const StateMatrix unsymmetric =
      P - product<StateMatrix>(K, PHt.transpose()) - product<StateMatrix>(rest, K.transpose());
  Posterior posterior{0.5 * (unsymmetric + unsymmetric.transpose()), K.norm(), false};
  posterior.is_sound = S_llt.info() == Eigen::Success && posterior.P.allFinite();
  return posterior;
}

bool is_usable(const HandPoseMeasurement& z, int joint_count) {
  return z.q.size() == joint_count && z.q.allFinite() && z.R_vision.allFinite() && is_finite(z.T_C_H) &&
         is_rotation(z.T_C_H.R) && (!z.has_second || (is_finite(z.T_C_H_second) && is_rotation(z.T_C_H_second.R)));
}

NoiseModel noise_of(const EkfOptions& options) {
  return {options.encoder_sigma_rad, options.floor_position_sigma_m, options.floor_rotation_sigma_rad};
}

}  // namespace

JointOffsetEkf::JointOffsetEkf(const SerialChain& chain, const EkfOptions& options)
    : chain_(chain), options_(options) {
  LearnedModel nothing_learnt;
  nothing_learnt.beta = JointVector::Zero(chain.joint_count);
  reset(nothing_learnt);
}

void JointOffsetEkf::reset(const LearnedModel& model) {
  StateVector sigma = StateVector::Constant(kErrorBeta + chain_.joint_count, options_.prior_beta_sigma_rad);
  sigma.segment<3>(kErrorV).setConstant(options_.prior_position_sigma_m);
  sigma.segment<3>(kErrorW).setConstant(options_.prior_rotation_sigma_rad);
  if (chain_.joint_count > 0) sigma[kErrorBeta] = options_.prior_beta1_sigma_rad;
  reset(model, sigma.cwiseAbs2().asDiagonal());
}

void JointOffsetEkf::reset(const LearnedModel& model, const StateMatrix& P) {
  assert(model.beta.size() == chain_.joint_count);
  assert(P.rows() == kErrorBeta + chain_.joint_count && P.cols() == P.rows());
  model_ = model;
  P_ = P;
}

void JointOffsetEkf::predict(double dt_s) {
  if (!(dt_s > 0.0) || !std::isfinite(dt_s)) return;
  const double minutes = dt_s / 60.0;
  const auto variance = [&](double walk) { return walk * walk * minutes; };
  P_.diagonal().segment<3>(kErrorV).array() += variance(options_.walk_position_m_per_sqrt_min);
  P_.diagonal().segment<3>(kErrorW).array() += variance(options_.walk_rotation_rad_per_sqrt_min);
  P_.diagonal().tail(chain_.joint_count).array() += variance(options_.walk_beta_rad_per_sqrt_min);
}

FusionReport JointOffsetEkf::update(const HandPoseMeasurement& z) {
  FusionReport report;
  if (!is_usable(z, chain_.joint_count)) return report;
  const HandEyePrediction before = predict_hand_eye(chain_, model_.T_C_B, model_.beta, z.q);
  const Matrix6 R = look_covariance(z.R_vision, before.H.rightCols(chain_.joint_count), noise_of(options_));
  const Problem problem{chain_, model_, P_, z.q, R, Eigen::LLT<Matrix6>(R)};
  report.outcome = FusionOutcome::kIllConditioned;
  if (problem.R_llt.info() != Eigen::Success) return report;

  const Choice chosen = choose(problem, z, options_.max_iterations);
  report.innovation = pose_error(chosen.is_second ? z.T_C_H_second : z.T_C_H, before.T_C_H);
  const Matrix6 S_before = product<Matrix6>(before.H, product<StateBy6>(P_, before.H.transpose())) + R;
  report.nis = report.innovation.dot(S_before.llt().solve(report.innovation));
  report.cost = chosen.best.trial.cost;
  report.iterations = chosen.best.iterations;
  if (!chosen.best.is_sound || !std::isfinite(report.nis)) return report;
  if (!(report.cost <= options_.cost_gate)) {
    report.outcome = FusionOutcome::kRejectedByGate;
    return report;
  }
  const Posterior posterior = joseph_update(P_, chosen.best.trial.H, R);
  if (!posterior.is_sound) return report;
  report.gain_norm = posterior.gain_norm;
  report.outcome = chosen.is_second ? FusionOutcome::kFusedSecondSolution : FusionOutcome::kFused;
  model_ = chosen.best.trial.model;
  P_ = posterior.P;
  return report;
}

Matrix6 JointOffsetEkf::predicted_hand_covariance(const JointVector& q) const {
  const MeasurementJacobian H = predict_hand_eye(chain_, model_.T_C_B, model_.beta, q).H;
  return H * P_ * H.transpose();
}

}  // namespace armsight
