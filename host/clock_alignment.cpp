#include "host/clock_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/convert.hpp"

namespace armsight::host {
namespace {

constexpr double kSkewPrior = 50e-6;          // σ of the rate difference before anything was measured
constexpr double kStampNoiseNs = 20e3;        // scheduling noise of a stamp: keeps the lowest round trips comparable
constexpr double kStepMarginNs = 1e6;         // a step is a miss of more than the bounds and this

/// The three stamps that came over the wire (the first is the peer's echo): their sums must not overflow.
bool is_on_the_wire(const ClockExchange& e) {
  return is_wire_time(to_ns(e.host_send)) && is_wire_time(to_ns(e.arm_receive)) && is_wire_time(to_ns(e.arm_send));
}

}  // namespace

void ClockAlignment::add(const ClockExchange& exchange) {
  if (!is_on_the_wire(exchange)) {
    ++dropped_;
    return;
  }
  const Duration out = exchange.arm_receive - exchange.host_send;
  const Duration back = exchange.arm_send - exchange.host_receive;
  const Duration round_trip = (exchange.host_receive - exchange.host_send) - (exchange.arm_send - exchange.arm_receive);
  if (round_trip.count() < 0 || exchange.arm_send < exchange.arm_receive) {
    ++dropped_;
    return;
  }
  const Sample sample{exchange.host_send + (exchange.host_receive - exchange.host_send) / 2,
                      out.count() + (back.count() - out.count()) / 2, round_trip.count()};
  off_line_in_a_row_ = is_off_the_line(sample) ? off_line_in_a_row_ + 1 : 0;
  if (off_line_in_a_row_ >= kStepSamples) {
    window_.clear();
    off_line_in_a_row_ = 0;
    ++steps_;
  }
  window_.push_back(sample);
  if (window_.size() > kWindow) window_.pop_front();
  fit();
}

void ClockAlignment::fit() {
  fitted_ = window_;
  const auto by_round_trip = [](const Sample& a, const Sample& b) { return a.round_trip_ns < b.round_trip_ns; };
  std::stable_sort(fitted_.begin(), fitted_.end(), by_round_trip);
  if (fitted_.size() > kFitted) fitted_.resize(kFitted);

  line_ = Line{window_.back().host_middle, fitted_.front().offset_ns, 0.0, 0.0};
  // Weighted least squares of offset + skew · t; the prior on the skew keeps a short window from inventing one.
  double sw = 0, st = 0, stt = 1.0 / (kSkewPrior * kSkewPrior), sy = 0, sty = 0;
  for (const Sample& s : fitted_) {
    const double sigma = 0.5 * static_cast<double>(s.round_trip_ns) + kStampNoiseNs;
    const double w = 1.0 / (sigma * sigma);
    const auto t = static_cast<double>((s.host_middle - line_.origin).count());
    const auto y = static_cast<double>(s.offset_ns - line_.base_ns);
    sw += w, st += w * t, stt += w * t * t, sy += w * y, sty += w * t * y;
  }
  const double determinant = sw * stt - st * st;
  line_.skew = std::clamp((sw * sty - st * sy) / determinant, -kMaxSkew, kMaxSkew);
  line_.offset_ns = (sy - line_.skew * st) / sw;
}

double ClockAlignment::residual_ns(const Sample& sample) const {
  const auto t = static_cast<double>((sample.host_middle - line_.origin).count());
  return static_cast<double>(sample.offset_ns - line_.base_ns) - (line_.offset_ns + line_.skew * t);
}

// At a sample the true offset lies within half its round trip, so the line is off by at most that and the residual;
// away from it the two rates may differ from the fitted skew by up to kMaxSkew + |skew|. The best sample counts.
double ClockAlignment::bound_ns(Time host_time) const {
  double best = std::numeric_limits<double>::infinity();
  for (const Sample& s : fitted_) {
    const double away = std::abs(static_cast<double>((host_time - s.host_middle).count()));
    const double at_sample = 0.5 * static_cast<double>(s.round_trip_ns) + std::abs(residual_ns(s));
    best = std::min(best, at_sample + (kMaxSkew + std::abs(line_.skew)) * away);
  }
  return best;
}

bool ClockAlignment::is_off_the_line(const Sample& sample) const {
  if (window_.empty()) return false;
  const double allowed = 0.5 * static_cast<double>(sample.round_trip_ns) + bound_ns(sample.host_middle) + kStepMarginNs;
  return std::abs(residual_ns(sample)) > allowed;
}

std::optional<AlignedTime> ClockAlignment::to_arm(Time host_time) const {
  if (window_.empty()) return std::nullopt;
  const auto t = static_cast<double>((host_time - line_.origin).count());
  const std::int64_t offset_ns = line_.base_ns + std::llround(line_.offset_ns + line_.skew * t);
  return AlignedTime{host_time + Duration{offset_ns}, Duration{std::llround(std::ceil(bound_ns(host_time)))}};
}

std::optional<Duration> ClockAlignment::bound() const {
  if (window_.empty()) return std::nullopt;
  return Duration{std::llround(std::ceil(bound_ns(window_.back().host_middle)))};
}

}  // namespace armsight::host
