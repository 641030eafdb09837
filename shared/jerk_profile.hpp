// One joint's motion with bounded jerk: the quickest change of speed, the stop, and the quickest step to a place.
// rad, rad/s, rad/s², rad/s³. Between two cycles the jerk is piecewise constant and switches where it must, not only at
// samples: so limits hold at all times, and with them those of the sampled sequence's difference quotients.
//
//   a ▲   ┌────┐         quickest change of speed: ramp to ±A (or to less, where the change is small), hold, ramp to 0
//     │  /      \        stop: the change to speed 0
//     └─┴────────┴─► t   to a place: the change to the cruising speed until stopping would end at the place; then stop
//
// Why that is quickest, and always safe: at every instant the stop alone ends inside the way; one switch of jerk later
// means every later speed is at least as great, so where the stop would end only rises, and the last moment is one.
// No heap, no throw, no loop but the bounded search for that moment.
#pragma once

#include <array>

namespace armsight {

struct AxisState {
  double q_rad = 0.0, speed_rad_s = 0.0, acceleration_rad_s2 = 0.0;
};

struct AxisLimits {
  double speed_rad_s = 0.0, acceleration_rad_s2 = 0.0, jerk_rad_s3 = 0.0;  ///< all > 0
};

/// Three pieces of constant jerk; afterwards no acceleration and `final_speed_rad_s`.
struct SpeedChange {
  std::array<double, 3> jerk_rad_s3{}, time_s{};
  double final_speed_rad_s = 0.0;
  double duration_s() const { return time_s[0] + time_s[1] + time_s[2]; }
};

/// Quickest way to a constant speed. An acceleration beyond its limit (lowered in flight) first ramps down to it.
SpeedChange change_speed(const AxisState& x, double speed_rad_s, const AxisLimits& limits);
inline SpeedChange stop(const AxisState& x, const AxisLimits& limits) { return change_speed(x, 0.0, limits); }

/// t ≥ 0 later on that course.
AxisState advance(const AxisState& x, const SpeedChange& course, double t_s);
AxisState end_of(const AxisState& x, const SpeedChange& course);

/// Speed that is left when the acceleration has been ramped to nothing: the extreme that cannot be avoided any more.
double coasting_speed(const AxisState& x, double jerk_rad_s3);

/// All places that the stop touches, its end among them.
struct StopSpan {
  double lowest_rad, highest_rad, end_rad;
};
StopSpan stop_span(const AxisState& x, const AxisLimits& limits);

/// One step of dt_s on the quickest way to rest at the target, not faster than limits.speed_rad_s (a greater speed is
/// given up as fast as allowed). A landing is exact.
AxisState step_to_place(const AxisState& x, double target_rad, const AxisLimits& limits, double dt_s);
AxisState step_to_rest(const AxisState& x, const AxisLimits& limits, double dt_s);

/// Seconds to rest at the target by that law.
double trip_time(const AxisState& x, double target_rad, const AxisLimits& limits);
/// Cruising speed ≤ limits.speed_rad_s with which the trip takes time_s, where it can be stretched so far.
double cruise_for_time(const AxisState& x, double target_rad, const AxisLimits& limits, double time_s);

}  // namespace armsight
