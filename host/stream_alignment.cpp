#include "host/stream_alignment.hpp"

#include <algorithm>
#include <cmath>

#include "host/cross_validation.hpp"

namespace armsight::host {
namespace {

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
  z.T_0_given = {a.R * so3_exp(share * so3_log(a.R.transpose() * b.R)), a.p + share * (b.p - a.p)};
  return true;
}

std::vector<Observation> looks_at_offset(const Dataset& dataset, double offset_s, std::vector<LeftOut>* left_out) {
  std::vector<Observation> looks;
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    Observation z = dataset.observations[i];
    if (posture_at(*dataset.stream, dataset.look_time_s[i] + offset_s, z)) looks.push_back(z);
    else if (left_out) left_out->push_back({z.label, "its time lies outside arm.csv"});
  }
  return looks;
}

double estimate_time_offset_s(const Dataset& dataset, const BatchOptions& options) {
  const Dataset some = thinned_inside(dataset);
  if (some.observations.size() < 10)
    throw ConfigError(dataset.folder.string() + ": looks.csv and arm.csv overlap in fewer than 10 looks");
  BatchOptions quick = options;
  quick.refined_starts = 1;
  quick.rounds = 1;
  constexpr int kSteps = 20;
  const double step = dataset.max_offset_s / kSteps;
  double best = 0.0, best_cost = cost_at(some, 0.0, quick);
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double cost = cost_at(some, k * step, quick);
    if (cost < best_cost) {
      best = k * step;
      best_cost = cost;
    }
  }
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double low = best - step, high = best + step;
  while (high - low > 1e-4) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    if (cost_at(some, a, quick) < cost_at(some, b, quick)) high = b;
    else low = a;
  }
  return 0.5 * (low + high);
}

}  // namespace armsight::host
