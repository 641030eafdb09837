#include "shared/joint_servo.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace armsight {
namespace {

/// Rounding of a landing: within it a joint stands exactly on its target.
constexpr double kLanded_rad = 1e-11, kLanded_rad_s = 1e-8;

/// Greatest speed at the end of this step (speed v now) that still lets a joint stop within `distance`: braking takes
/// whole steps of A·dt and a last smaller one, so with k whole steps left the way is
/// ½ v dt + (k+1) v' dt − ½ k(k+1) A dt²; solved for v'. Equality, kept step by step, ends exactly there.
double approach_speed(double distance, double v, double A, double dt) {
  const double way = distance - 0.5 * v * dt;
  if (way <= 0.0) return 0.0;
  const double unit = A * dt * dt;
  const double k = std::floor(0.5 * (std::sqrt(1.0 + 8.0 * way / unit) - 1.0));
  return (way + 0.5 * k * (k + 1.0) * unit) / ((k + 1.0) * dt);
}

/// Shortest time to `distance` ≥ 0 and rest there, from speed v towards it (v < 0: away).
double least_time(double distance, double v, double V, double A) {
  const double braking = v * v / (2.0 * A);
  if (v < 0.0) return -v / A + least_time(distance + braking, 0.0, V, A);
  if (distance < braking) return v / A + least_time(braking - distance, 0.0, V, A);
  if (v > V) return v / A + (distance - braking) / V;
  const double peak = std::sqrt(A * distance + 0.5 * v * v);
  if (peak <= V) return (2.0 * peak - v) / A;
  return (V - v) / A + (distance + braking) / V;
}

/// Cruising speed with which that takes the time T instead, V where it cannot be stretched.
double cruise_speed(double distance, double v, double V, double A, double T) {
  const double braking = v * v / (2.0 * A);
  if (v < 0.0) return cruise_speed(distance + braking, 0.0, V, A, T + v / A);
  if (distance <= braking) return V;
  const double b = A * T + v;
  const double discriminant = b * b - 4.0 * (A * distance + 0.5 * v * v);
  if (discriminant < 0.0) return V;
  const double faster = 0.5 * (b - std::sqrt(discriminant));
  return std::min(V, faster >= v ? faster : (distance - braking) / (T - v / A));
}

}  // namespace

JointServo::JointServo(const JointLimits& limits) : limits_(limits) {
  reset(JointVector::Zero(limits.min_rad.size()));
}

void JointServo::reset(const JointVector& q_rad) {
  assert(q_rad.size() == limits_.min_rad.size());
  setpoint_ = {q_rad, JointVector::Zero(q_rad.size()), JointVector::Zero(q_rad.size())};
}

void JointServo::move_joint(Eigen::Index i, double wanted_rad_s, double dt_s) {
  const double q = setpoint_.q_rad[i], v = setpoint_.speed_rad_s[i];
  const double V = limits_.max_speed_rad_s[i], A = limits_.max_acceleration_rad_s2[i];
  const double upper = std::min(V, approach_speed(limits_.max_rad[i] - q, v, A, dt_s));
  const double lower = -std::min(V, approach_speed(q - limits_.min_rad[i], -v, A, dt_s));
  const double next = std::clamp(std::clamp(wanted_rad_s, lower, upper), v - A * dt_s, v + A * dt_s);
  // A joint that starts outside its limits may come back but goes no further; rounding ends at the limit.
  const double q_next = std::clamp(q + 0.5 * (v + next) * dt_s, std::min(q, limits_.min_rad[i]),
                                   std::max(q, limits_.max_rad[i]));
  setpoint_.q_rad[i] = q_next;
  setpoint_.speed_rad_s[i] = next;
  setpoint_.acceleration_rad_s2[i] = (next - v) / dt_s;
}

const JointSetpoint& JointServo::step_towards(const JointVector& target_rad, double speed_scale, double dt_s) {
  const bool is_sound = target_rad.size() == setpoint_.q_rad.size() && target_rad.allFinite() && speed_scale > 0.0;
  if (!is_sound) return step_to_rest(dt_s);
  if (!(dt_s > 0.0) || !std::isfinite(dt_s)) return setpoint_;
  const JointVector target = target_rad.cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad);
  const JointVector speed = std::min(speed_scale, 1.0) * limits_.max_speed_rad_s;
  const JointVector& acceleration = limits_.max_acceleration_rad_s2;
  const JointVector way = target - setpoint_.q_rad;
  const auto towards = [&](Eigen::Index i) { return std::copysign(1.0, way[i]) * setpoint_.speed_rad_s[i]; };
  JointVector time = JointVector::Zero(target.size());
  for (Eigen::Index i = 0; i < target.size(); ++i) {
    time[i] = least_time(std::abs(way[i]), towards(i), speed[i], acceleration[i]);
  }
  const double slowest = time.maxCoeff();
  for (Eigen::Index i = 0; i < target.size(); ++i) {
    const double v = towards(i), A = acceleration[i];
    const bool can_wait = time[i] < slowest - dt_s;
    const double cruise = can_wait ? cruise_speed(std::abs(way[i]), v, speed[i], A, slowest) : speed[i];
    const double wanted = std::min(cruise, approach_speed(std::abs(way[i]), v, A, dt_s));
    move_joint(i, std::copysign(wanted, way[i]), dt_s);
    const bool has_landed = std::abs(target[i] - setpoint_.q_rad[i]) < kLanded_rad &&
                            std::abs(setpoint_.speed_rad_s[i]) < kLanded_rad_s;
    if (!has_landed) continue;
    setpoint_.q_rad[i] = target[i];
    setpoint_.speed_rad_s[i] = 0.0;
  }
  return setpoint_;
}

const JointSetpoint& JointServo::step_with_speed(const JointVector& speed_rad_s, double dt_s) {
  if (!(dt_s > 0.0) || !std::isfinite(dt_s)) return setpoint_;
  const bool is_sound = speed_rad_s.size() == setpoint_.q_rad.size() && speed_rad_s.allFinite();
  for (Eigen::Index i = 0; i < setpoint_.q_rad.size(); ++i) move_joint(i, is_sound ? speed_rad_s[i] : 0.0, dt_s);
  return setpoint_;
}

const JointSetpoint& JointServo::step_to_rest(double dt_s) {
  return step_with_speed(JointVector::Zero(setpoint_.q_rad.size()), dt_s);
}

bool JointServo::is_at_rest() const { return (setpoint_.speed_rad_s.array() == 0.0).all(); }

}  // namespace armsight
