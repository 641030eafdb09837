#include "host/stream_alignment.hpp"

#include <algorithm>
#include <cmath>

#include "host/cross_validation.hpp"
#include "host/observability.hpp"

namespace armsight::host {
namespace {

constexpr int kOffsetRounds = 4;  // of first-order motion about the offset so far; the last moves by microseconds

constexpr double kStands_m = 0.001, kStands_rad = 0.1 * kDegree;  // moved by less: the same place

bool is_same_place(const Observation& a, const Observation& b) {
  const bool same_joints = a.q.size() == 0 || (a.q - b.q).cwiseAbs().maxCoeff() < kStands_rad;
  return same_joints && (a.T_0_given.p - b.T_0_given.p).norm() < kStands_m &&
         rotation_angle(a.T_0_given.R, b.T_0_given.R) < kStands_rad;
}

/// A thinned copy whose looks lie inside the stream at every offset tried, so that all offsets are judged on the same.
Dataset thinned_inside(const Dataset& dataset) {
  Dataset some = dataset;
  some.observations.clear();
  some.look_time_s.clear();
  const double first = dataset.stream->time_s.front() + dataset.max_offset_s;
  const double last = dataset.stream->time_s.back() - dataset.max_offset_s;
  constexpr std::size_t kMost = 150;
  const std::size_t step = dataset.observations.size() / kMost + 1;
  for (std::size_t i = 0; i < dataset.observations.size(); i += step) {
    if (dataset.look_time_s[i] < first || dataset.look_time_s[i] > last) continue;
    some.observations.push_back(dataset.observations[i]);
    some.look_time_s.push_back(dataset.look_time_s[i]);
  }
  return some;
}

double cost_at(const Dataset& some, double offset_s, const BatchOptions& options) {
  const auto looks = looks_at_offset(some, offset_s, nullptr);
  return robust_score(learn(some.model, looks, options).model, looks, options.noise);
}

}  // namespace

bool posture_at(const ArmStream& stream, double time_s, Observation& z) {
  if (stream.time_s.empty() || time_s < stream.time_s.front() || time_s > stream.time_s.back()) return false;
  const auto after = std::upper_bound(stream.time_s.begin(), stream.time_s.end(), time_s);
  const auto i = static_cast<std::size_t>(after - stream.time_s.begin()) - 1;  // the last of repeated stamps
  const std::size_t j = std::min(i + 1, stream.time_s.size() - 1);
  const double span = stream.time_s[j] - stream.time_s[i];
  const double share = span > 0.0 ? (time_s - stream.time_s[i]) / span : 0.0;
  z.q = stream.q[i] + share * (stream.q[j] - stream.q[i]);
  const Pose &a = stream.T_0_given[i], &b = stream.T_0_given[j];
  const Vector3 turn = so3_log(a.R.transpose() * b.R), way = b.p - a.p;
  z.T_0_given = {a.R * so3_exp(share * turn), a.p + share * way};
  z.q_rate.setZero(z.q.size());
  z.given_rate.setZero();
  if (span <= 0.0) return true;
  z.q_rate = (stream.q[j] - stream.q[i]) / span;
  z.given_rate << way / span, a.R * turn / span;
  return true;
}

std::vector<Observation> looks_at_offset(const Dataset& dataset, double offset_s, std::vector<LeftOut>* left_out) {
  std::vector<Observation> looks;
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    Observation z = dataset.observations[i];
    z.at_offset_s = offset_s;
    if (posture_at(*dataset.stream, dataset.look_time_s[i] + offset_s, z)) looks.push_back(z);
    else if (left_out) left_out->push_back({z.label, "its time lies outside arm.csv"});
  }
  return looks;
}

Dataset without_repeats(const Dataset& dataset) {
  Dataset some = dataset;
  some.observations.clear();
  some.look_time_s.clear();
  std::optional<Observation> last;
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    Observation z = dataset.observations[i];
    if (last && posture_at(*dataset.stream, dataset.look_time_s[i], z) && is_same_place(z, *last)) continue;
    if (posture_at(*dataset.stream, dataset.look_time_s[i], z)) last = z;
    some.observations.push_back(dataset.observations[i]);
    some.look_time_s.push_back(dataset.look_time_s[i]);
  }
  return some;
}

TimeOffset estimate_time_offset(const Dataset& dataset, const BatchOptions& options) {
  const Dataset some = thinned_inside(dataset);
  if (some.observations.size() < 10)
    throw ConfigError(dataset.folder.string() + ": looks.csv and arm.csv overlap in fewer than 10 looks");
  BatchOptions quick = options;
  quick.refined_starts = 1;
  quick.rounds = 1;
  constexpr int kSteps = 20;
  const double step = dataset.max_offset_s / kSteps;
  TimeOffset best;
  double best_cost = cost_at(some, 0.0, quick);
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double cost = k == 0 ? best_cost : cost_at(some, k * step, quick);
    if (cost >= best_cost) continue;
    best.offset_s = k * step;
    best_cost = cost;
  }
  for (int round = 0; round < kOffsetRounds; ++round) {
    const auto looks = looks_at_offset(dataset, best.offset_s, nullptr);
    ChainModel model = some.model;
    if (round == 0) model = learn(model, looks, quick).model;
    model.time_offset.value = best.offset_s;
    model.time_offset.freedom = Freedom::kFree;
    const BatchSolution solution = learn(model, looks, options);
    const double most = dataset.max_offset_s;
    best.offset_s = std::clamp(solution.model.time_offset.value, -most, most);
    const Eigen::MatrixXd P = covariance_of(solution.model, solution.observations, solution.used, solution.noise);
    best.sigma_s = std::max(solution.misfit, 1.0) * std::sqrt(P(P.rows() - 1, P.rows() - 1));
  }
  return best;
}

}  // namespace armsight::host
