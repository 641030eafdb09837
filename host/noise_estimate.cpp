#include "host/noise_estimate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace armsight::host {
namespace {

constexpr double kFreedoms = 4.0;       // of the t-likelihood
constexpr std::size_t kMostLooks = 200;  // more tell no more about two numbers
constexpr double kLeastFloor_m = 1e-6, kLeastFloor_rad = 1e-6;

/// By how much a look's pose is off, and the covariance that corners and encoders alone give this.
struct PoseMiss {
  Vector6 e;
  Matrix6 C;
};

std::optional<PoseMiss> miss_of(const ChainModel& model, const Observation& z, const NoiseModel& given) {
  const LookUnknowns columns = look_unknowns(model, z.target);
  const auto residual = residual_of(model, z, columns);
  if (!residual) return std::nullopt;
  const NoiseModel encoders{given.encoder_sigma_rad, 0.0, 0.0};
  const auto joints = static_cast<Eigen::Index>(columns.joints.size());
  const PosePrediction prediction = predict_T_C_M(model, z, columns);
  const auto J_q = prediction.J.middleCols(LookUnknowns::kFirstOffset, joints);
  if (!z.has_corners()) return PoseMiss{residual->r, look_covariance(z.R_vision, J_q, encoders)};
  const Matrix6 information = residual->G.transpose() * residual->G;
  const Eigen::LDLT<Matrix6> solver(information);
  if (solver.info() != Eigen::Success || solver.rcond() < 1e-14) return std::nullopt;
  const Matrix6 corners = z.sigma_px * z.sigma_px * solver.solve(Matrix6::Identity());
  return PoseMiss{solver.solve(residual->G.transpose() * residual->r), look_covariance(corners, J_q, encoders)};
}

double middle(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// −2 log likelihood of the misses with this floor.
double misfit_of(const std::vector<PoseMiss>& misses, double floor_m, double floor_rad) {
  double sum = 0.0;
  for (const auto& miss : misses) {
    Matrix6 C = miss.C;
    C.diagonal().head<3>().array() += floor_m * floor_m;
    C.diagonal().tail<3>().array() += floor_rad * floor_rad;
    const Eigen::LLT<Matrix6> llt(C);
    const double squared = llt.matrixL().solve(miss.e).squaredNorm();
    sum += 2.0 * llt.matrixLLT().diagonal().array().log().sum() + (kFreedoms + 6.0) * std::log1p(squared / kFreedoms);
  }
  return sum;
}

/// Golden section over log x between low and high.
template <class Cost>
double smallest(double low, double high, Cost cost) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double a = std::log(low), b = std::log(high);
  double c = b - golden * (b - a), d = a + golden * (b - a);
  double cost_c = cost(std::exp(c)), cost_d = cost(std::exp(d));
  while (b - a > 0.05) {
    if (cost_c < cost_d) {
      b = d;
      d = c;
      cost_d = cost_c;
      c = b - golden * (b - a);
      cost_c = cost(std::exp(c));
    } else {
      a = c;
      c = d;
      cost_c = cost_d;
      d = a + golden * (b - a);
      cost_d = cost(std::exp(d));
    }
  }
  return std::exp(0.5 * (a + b));
}

}  // namespace

NoiseModel estimated_floor(const ChainModel& model, const std::vector<Observation>& observations,
                           const std::vector<char>& used, const NoiseModel& given) {
  std::vector<PoseMiss> misses;
  std::vector<double> metres, radians;
  const std::size_t step = observations.size() / kMostLooks + 1;
  std::size_t rows = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    rows += used[i] ? 6 : 0;
    if (!used[i] || i % step != 0) continue;
    const auto miss = miss_of(model, observations[i], given);
    if (!miss) continue;
    misses.push_back(*miss);
    metres.push_back(miss->e.head<3>().norm());
    radians.push_back(miss->e.tail<3>().norm());
  }
  const auto unknowns = static_cast<std::size_t>(unknown_layout(model).columns);
  if (misses.size() < 4 || rows <= unknowns) return given;
  const double start_m = std::max(middle(metres) / 1.54, kLeastFloor_m);  // 1.54: median norm of a unit 3-D normal
  const double start_rad = std::max(middle(radians) / 1.54, kLeastFloor_rad);
  double floor_m = start_m, floor_rad = start_rad;
  for (int round = 0; round < 2; ++round) {
    floor_m = smallest(start_m / 30.0, 2.0 * start_m, [&](double x) { return misfit_of(misses, x, floor_rad); });
    floor_rad = smallest(start_rad / 30.0, 2.0 * start_rad, [&](double x) { return misfit_of(misses, floor_m, x); });
  }
  const double fitted = std::sqrt(static_cast<double>(rows) / static_cast<double>(rows - std::min(unknowns, rows / 2)));
  return {given.encoder_sigma_rad, fitted * floor_m, fitted * floor_rad};
}

double estimated_sigma_px(const ChainModel& model, const std::vector<Observation>& observations,
                          const std::vector<char>& used) {
  std::vector<double> each;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& z = observations[i];
    if (!used[i] || !z.has_corners() || z.rows() <= 6) continue;
    const auto residual = residual_of(model, z, look_unknowns(model, z.target));
    if (!residual) continue;
    const Eigen::LDLT<Matrix6> solver(Matrix6(residual->G.transpose() * residual->G));
    const Eigen::VectorXd rest = residual->r - residual->G * solver.solve(residual->G.transpose() * residual->r);
    each.push_back(rest.norm() / std::sqrt(static_cast<double>(z.rows() - 6)));
  }
  return each.empty() ? 0.0 : middle(each);
}

}  // namespace armsight::host
