#include "shared/jerk_profile.hpp"

#include <algorithm>
#include <cmath>

namespace armsight {
namespace {

/// Rounding of a place: two this near are the same.
constexpr double kSamePlace_rad = 1e-15;

AxisState integrate(const AxisState& x, double jerk, double t) {
  const double v = x.speed_rad_s, a = x.acceleration_rad_s2;
  return {x.q_rad + t * (v + t * (a / 2.0 + t * jerk / 6.0)), v + t * (a + t * jerk / 2.0), a + t * jerk};
}

double stop_end(const AxisState& x, const AxisLimits& limits) { return end_of(x, stop(x, limits)).q_rad; }

bool is_same_place(double a, double b) { return std::abs(a - b) <= kSamePlace_rad * std::max(1.0, std::abs(a)); }

/// Last moment in [0, dt] at which a stop ends not beyond the target; at 0 it does not, at dt it does. Regula falsi
/// (Illinois), which the bracket keeps safe; 60 rounds at most, about 8 in the mean.
double last_moment(const AxisState& x, const SpeedChange& onward, double target, double sign, const AxisLimits& limits,
                   double missing_at_0, double missing_at_dt, double dt) {
  double early = 0.0, late = dt, f_early = missing_at_0, f_late = missing_at_dt;
  for (int round = 0; round < 60 && late - early > 1e-16 * dt; ++round) {
    const double inner = early + (late - early) * f_early / (f_early - f_late);
    const bool halve = round > 20 || !(inner > early && inner < late);
    const double t = halve ? 0.5 * (early + late) : inner;
    const double f = sign * (target - stop_end(advance(x, onward, t), limits));
    if (std::abs(f) <= 0.25 * kSamePlace_rad) return t;
    if (f >= 0.0) {
      early = t;
      f_early = f;
      f_late *= 0.5;
    } else {
      late = t;
      f_late = f;
      f_early *= 0.5;
    }
  }
  return early;
}

/// The trip as seen in its direction, in which the target lies beyond where a stop would end.
struct Trip {
  AxisState x;
  double way;
};

Trip trip_to(const AxisState& x, double target, const AxisLimits& limits) {
  const double sign = std::copysign(1.0, target - stop_end(x, limits));
  return {{0.0, sign * x.speed_rad_s, sign * x.acceleration_rad_s2}, sign * (target - x.q_rad)};
}

struct Timing {
  double ramps_s, cruise_rad;  ///< duration of both speed changes, and the way left between them
};

Timing timing_at(const Trip& trip, double cruise, const AxisLimits& limits) {
  const SpeedChange up = change_speed(trip.x, cruise, limits);
  const AxisState there = end_of(trip.x, up);
  const SpeedChange down = stop(there, limits);
  return {up.duration_s() + down.duration_s(), trip.way - end_of(there, down).q_rad};
}

constexpr int kHalvings = 40;

/// Greatest cruising speed from which the trip can still stop in time; 0: the stop has begun already.
double peak_speed(const Trip& trip, const AxisLimits& limits) {
  double low = std::clamp(coasting_speed(trip.x, limits.jerk_rad_s3), 0.0, limits.speed_rad_s);
  double high = limits.speed_rad_s;
  if (timing_at(trip, high, limits).cruise_rad >= 0.0) return high;
  if (timing_at(trip, low, limits).cruise_rad < 0.0) return 0.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (timing_at(trip, middle, limits).cruise_rad >= 0.0 ? low : high) = middle;
  }
  return low;
}

double time_at(const Trip& trip, double cruise, const AxisLimits& limits) {
  const Timing t = timing_at(trip, cruise, limits);
  return t.ramps_s + std::max(0.0, t.cruise_rad) / cruise;
}

}  // namespace

SpeedChange change_speed(const AxisState& x, double speed, const AxisLimits& limits) {
  const double A = limits.acceleration_rad_s2, J = limits.jerk_rad_s3;
  const double s = std::copysign(1.0, speed - coasting_speed(x, J));
  const double a = s * x.acceleration_rad_s2;                                   // seen in the direction of the change
  const double gain = std::max(s * (speed - x.speed_rad_s), a * std::abs(a) / (2.0 * J));
  const double peak = std::sqrt(std::max(0.0, J * gain + 0.5 * a * a));
  if (a > A) return {{-s * J, 0.0, -s * J}, {(a - A) / J, (gain - a * a / (2.0 * J)) / A, A / J}, speed};
  if (peak > A) return {{s * J, 0.0, -s * J}, {(A - a) / J, (gain - (A * A - 0.5 * a * a) / J) / A, A / J}, speed};
  return {{s * J, 0.0, -s * J}, {std::max(0.0, (peak - a) / J), 0.0, peak / J}, speed};
}

AxisState advance(const AxisState& x, const SpeedChange& course, double t_s) {
  AxisState now = x;
  for (std::size_t i = 0; i < course.time_s.size(); ++i) {
    if (t_s < course.time_s[i]) return integrate(now, course.jerk_rad_s3[i], t_s);
    now = integrate(now, course.jerk_rad_s3[i], course.time_s[i]);
    t_s -= course.time_s[i];
  }
  return {now.q_rad + t_s * course.final_speed_rad_s, course.final_speed_rad_s, 0.0};
}

AxisState end_of(const AxisState& x, const SpeedChange& course) {
  AxisState now = x;
  for (std::size_t i = 0; i < course.time_s.size(); ++i) now = integrate(now, course.jerk_rad_s3[i], course.time_s[i]);
  return {now.q_rad, course.final_speed_rad_s, 0.0};
}

double coasting_speed(const AxisState& x, double jerk_rad_s3) {
  return x.speed_rad_s + x.acceleration_rad_s2 * std::abs(x.acceleration_rad_s2) / (2.0 * jerk_rad_s3);
}

StopSpan stop_span(const AxisState& x, const AxisLimits& limits) {
  const double end = stop_end(x, limits), J = limits.jerk_rad_s3;
  double turn = x.q_rad;
  // A stop that must turn round does so while the acceleration is ramped down: v t − ½|a|t² + …, at its first root.
  const bool turns = x.speed_rad_s * coasting_speed(x, J) < 0.0 && x.speed_rad_s * x.acceleration_rad_s2 < 0.0;
  if (turns) {
    const double v = std::abs(x.speed_rad_s), a = std::abs(x.acceleration_rad_s2);
    const double t = 2.0 * v / (a + std::sqrt(std::max(0.0, a * a - 2.0 * J * v)));
    turn = integrate(x, -std::copysign(J, x.acceleration_rad_s2), t).q_rad;
  }
  return {std::min({x.q_rad, turn, end}), std::max({x.q_rad, turn, end}), end};
}

AxisState step_to_rest(const AxisState& x, const AxisLimits& limits, double dt_s) {
  return advance(x, stop(x, limits), dt_s);
}

AxisState step_to_place(const AxisState& x, double target_rad, const AxisLimits& limits, double dt_s) {
  const double missing = target_rad - stop_end(x, limits), sign = std::copysign(1.0, missing);
  AxisState next;
  if (is_same_place(target_rad, target_rad - missing)) {
    next = step_to_rest(x, limits, dt_s);
  } else {
    const SpeedChange onward = change_speed(x, sign * limits.speed_rad_s, limits);
    next = advance(x, onward, dt_s);
    const double missing_then = sign * (target_rad - stop_end(next, limits));
    if (missing_then < 0.0) {
      const double t = last_moment(x, onward, target_rad, sign, limits, std::abs(missing), missing_then, dt_s);
      next = step_to_rest(advance(x, onward, t), limits, dt_s - t);
    }
  }
  const bool is_still = next.speed_rad_s == 0.0 && next.acceleration_rad_s2 == 0.0;
  if (is_still && is_same_place(target_rad, next.q_rad)) next.q_rad = target_rad;
  return next;
}

double trip_time(const AxisState& x, double target_rad, const AxisLimits& limits) {
  const Trip trip = trip_to(x, target_rad, limits);
  const double peak = peak_speed(trip, limits);
  return peak > 0.0 ? time_at(trip, peak, limits) : stop(x, limits).duration_s();
}

double cruise_for_time(const AxisState& x, double target_rad, const AxisLimits& limits, double time_s) {
  const Trip trip = trip_to(x, target_rad, limits);
  double high = peak_speed(trip, limits), low = 0.0;
  if (!(high > 0.0) || time_at(trip, high, limits) >= time_s) return limits.speed_rad_s;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const bool is_slow = timing_at(trip, middle, limits).cruise_rad >= 0.0 && time_at(trip, middle, limits) > time_s;
    (is_slow ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace armsight
