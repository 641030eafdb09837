#include "shared/joint_servo.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace armsight {
namespace {

/// A joint with less to go than this needs no share of the line.
constexpr double kNoWay_rad = 1e-9;

bool is_step(double dt_s) { return dt_s > 0.0 && std::isfinite(dt_s); }
std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

JointServo::JointServo(const JointLimits& limits) : limits_(limits), wanted_limits_(limits) {
  reset(JointVector::Zero(limits.min_rad.size()));
}

void JointServo::reset(const JointVector& q_rad) {
  assert(q_rad.size() == limits_.min_rad.size());
  setpoint_ = {q_rad, JointVector::Zero(q_rad.size()), JointVector::Zero(q_rad.size())};
  limits_ = wanted_limits_;
  waits_ = {};
  trip_target_ = q_rad;
  trip_scale_ = 0.0;
  for (Eigen::Index i = 0; i < q_rad.size(); ++i) trip_limits_[index(i)] = axis_limits(i);
}

void JointServo::set_limits(const JointLimits& limits) {
  assert(limits.min_rad.size() == limits_.min_rad.size());
  wanted_limits_ = limits;
  limits_.min_rad = limits.min_rad;
  limits_.max_rad = limits.max_rad;
  limits_.max_speed_rad_s = limits.max_speed_rad_s;
  for (Eigen::Index i = 0; i < limits.min_rad.size(); ++i) {
    waits_[index(i)] = true;
    trip_limits_[index(i)] = axis_limits(i);
  }
  trip_scale_ = 0.0;
}

AxisState JointServo::axis(Eigen::Index i) const {
  return {setpoint_.q_rad[i], setpoint_.speed_rad_s[i], setpoint_.acceleration_rad_s2[i]};
}

AxisLimits JointServo::axis_limits(Eigen::Index i, double speed_scale) const {
  return {speed_scale * limits_.max_speed_rad_s[i], limits_.max_acceleration_rad_s2[i], limits_.max_jerk_rad_s3[i]};
}

void JointServo::put(Eigen::Index i, const AxisState& x) {
  setpoint_.q_rad[i] = x.q_rad;
  setpoint_.speed_rad_s[i] = x.speed_rad_s;
  setpoint_.acceleration_rad_s2[i] = x.acceleration_rad_s2;
}

void JointServo::adopt_limits() {
  for (Eigen::Index i = 0; i < limits_.min_rad.size(); ++i) {
    const AxisLimits wanted{limits_.max_speed_rad_s[i], wanted_limits_.max_acceleration_rad_s2[i],
                            wanted_limits_.max_jerk_rad_s3[i]};
    if (!waits_[index(i)] || !may_adopt(i, wanted)) continue;
    limits_.max_acceleration_rad_s2[i] = wanted.acceleration_rad_s2;
    limits_.max_jerk_rad_s3[i] = wanted.jerk_rad_s3;
    trip_limits_[index(i)] = wanted;
    trip_scale_ = 0.0;
    waits_[index(i)] = false;
  }
}

/// The stop may touch no place, and the coasting reach no speed, beyond the limits, unless it cannot be helped.
bool JointServo::may_adopt(Eigen::Index i, const AxisLimits& wanted) const {
  const AxisState x = axis(i);
  const AxisLimits now = axis_limits(i);
  const StopSpan then = stop_span(x, wanted), best = stop_span(x, now);
  const double coasting = std::abs(coasting_speed(x, wanted.jerk_rad_s3));
  return then.lowest_rad >= std::min(limits_.min_rad[i], best.lowest_rad) &&
         then.highest_rad <= std::max(limits_.max_rad[i], best.highest_rad) &&
         coasting <= std::max(now.speed_rad_s, std::abs(coasting_speed(x, now.jerk_rad_s3)));
}

void JointServo::plan_trip(const JointVector& target, double speed_scale) {
  if (target == trip_target_ && speed_scale == trip_scale_) return;
  trip_target_ = target;
  trip_scale_ = speed_scale;
  for (Eigen::Index i = 0; i < target.size(); ++i) trip_limits_[index(i)] = axis_limits(i, speed_scale);
  if (is_at_rest()) plan_on_a_line((target - setpoint_.q_rad).cwiseAbs(), speed_scale);
  else plan_in_motion(target, speed_scale);
}

void JointServo::plan_on_a_line(const JointVector& way, double speed_scale) {
  AxisLimits line{HUGE_VAL, HUGE_VAL, HUGE_VAL};                               // of the part of the way gone, 0 to 1
  for (Eigen::Index i = 0; i < way.size(); ++i) {
    if (way[i] < kNoWay_rad) continue;
    const AxisLimits own = axis_limits(i, speed_scale);
    line.speed_rad_s = std::min(line.speed_rad_s, own.speed_rad_s / way[i]);
    line.acceleration_rad_s2 = std::min(line.acceleration_rad_s2, own.acceleration_rad_s2 / way[i]);
    line.jerk_rad_s3 = std::min(line.jerk_rad_s3, own.jerk_rad_s3 / way[i]);
  }
  for (Eigen::Index i = 0; i < way.size(); ++i) {
    if (way[i] < kNoWay_rad) continue;
    trip_limits_[index(i)] = {line.speed_rad_s * way[i], line.acceleration_rad_s2 * way[i], line.jerk_rad_s3 * way[i]};
  }
}

void JointServo::plan_in_motion(const JointVector& target, double speed_scale) {
  double slowest_s = 0.0;
  for (Eigen::Index i = 0; i < target.size(); ++i)
    slowest_s = std::max(slowest_s, trip_time(axis(i), target[i], axis_limits(i, speed_scale)));
  for (Eigen::Index i = 0; i < target.size(); ++i)
    trip_limits_[index(i)].speed_rad_s = cruise_for_time(axis(i), target[i], axis_limits(i, speed_scale), slowest_s);
}

const JointSetpoint& JointServo::step_towards(const JointVector& target_rad, double speed_scale, double dt_s) {
  const bool is_sound = target_rad.size() == setpoint_.q_rad.size() && target_rad.allFinite() && speed_scale > 0.0;
  if (!is_sound) return step_to_rest(dt_s);
  if (!is_step(dt_s)) return setpoint_;
  adopt_limits();
  const JointVector target = target_rad.cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad);
  plan_trip(target, std::min(speed_scale, 1.0));
  for (Eigen::Index i = 0; i < target.size(); ++i) {
    const AxisLimits& limits = trip_limits_[index(i)];
    put(i, waits_[index(i)] ? armsight::step_to_rest(axis(i), limits, dt_s)
                            : step_to_place(axis(i), target[i], limits, dt_s));
  }
  return setpoint_;
}

AxisState JointServo::step_axis_with_speed(Eigen::Index i, double wanted_rad_s, double dt_s) const {
  const AxisState x = axis(i);
  AxisLimits limits = axis_limits(i);
  const double end = stop_span(x, limits).end_rad, place = wanted_rad_s > 0.0 ? limits_.max_rad[i] : limits_.min_rad[i];
  const bool has_room = wanted_rad_s > 0.0 ? end < place : end > place;
  if (wanted_rad_s == 0.0 || !has_room || waits_[index(i)]) return armsight::step_to_rest(x, limits, dt_s);
  limits.speed_rad_s = std::min(limits.speed_rad_s, std::abs(wanted_rad_s));
  return step_to_place(x, place, limits, dt_s);
}

const JointSetpoint& JointServo::step_with_speed(const JointVector& speed_rad_s, double dt_s) {
  const bool is_sound = speed_rad_s.size() == setpoint_.q_rad.size() && speed_rad_s.allFinite();
  if (!is_sound) return step_to_rest(dt_s);
  if (!is_step(dt_s)) return setpoint_;
  adopt_limits();
  trip_scale_ = 0.0;
  for (Eigen::Index i = 0; i < setpoint_.q_rad.size(); ++i) {
    trip_limits_[index(i)] = axis_limits(i);
    put(i, step_axis_with_speed(i, speed_rad_s[i], dt_s));
  }
  return setpoint_;
}

const JointSetpoint& JointServo::step_to_rest(double dt_s) {
  if (!is_step(dt_s)) return setpoint_;
  adopt_limits();
  trip_scale_ = 0.0;
  for (Eigen::Index i = 0; i < setpoint_.q_rad.size(); ++i)
    put(i, armsight::step_to_rest(axis(i), trip_limits_[index(i)], dt_s));
  return setpoint_;
}

JointVector JointServo::stopping_rad(double part) const {
  JointVector q = setpoint_.q_rad;
  std::array<SpeedChange, kMaxJoints> courses;
  double longest_s = 0.0;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    courses[index(i)] = armsight::stop(axis(i), trip_limits_[index(i)]);
    longest_s = std::max(longest_s, courses[index(i)].duration_s());
  }
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = advance(axis(i), courses[index(i)], std::min(part * longest_s, courses[index(i)].duration_s())).q_rad;
  return q;
}

JointVector JointServo::stopping_excursion_rad(const JointVector& q_rad) const {
  JointVector excursion(q_rad.size());
  for (Eigen::Index i = 0; i < q_rad.size(); ++i) {
    const StopSpan span = stop_span(axis(i), trip_limits_[index(i)]);
    excursion[i] = std::max(std::abs(span.lowest_rad - q_rad[i]), std::abs(span.highest_rad - q_rad[i]));
  }
  return excursion;
}

bool JointServo::is_at_rest() const {
  return (setpoint_.speed_rad_s.array() == 0.0).all() && (setpoint_.acceleration_rad_s2.array() == 0.0).all();
}

}  // namespace armsight
