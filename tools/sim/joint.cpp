#include "tools/sim/joint.hpp"

#include <algorithm>
#include <cmath>

namespace armsight::sim {

namespace {

constexpr double kFollowTime_s = 0.025;
constexpr double kMaxSpeed_rad_s = 6.0;               // actuator, specification §4.4
constexpr double kMaxAcceleration_rad_s2 = 60.0;
constexpr double kQuickStop_rad_s2 = 20.0;
constexpr double kCreep_rad_s = 1.0;                  // of the joint's zero, when it drifts
constexpr double kSpringTime_s = 0.05;
constexpr double kFollowingWindow_rad = 0.35;
constexpr double kGive = 0.04;                        // of an obstacle, per radian that the drive presses on
constexpr double kInertia_kg_m2 = 0.03;               // an arm's link, at the joint
constexpr double kFriction_Nms_rad = 0.05;
constexpr double kRatedTorque_Nm = 6.0;               // of torque_permille; actuator, specification §4.4
constexpr double kPresetSpeed_per_s = 2.0;            // of a spring's whole preset
constexpr double kStiffness_permille_rad = 8000.0;    // torque shown for the distance between target and joint

}  // namespace

Joint::Joint(const JointTruth& truth, double start_rad, double load_Nm)
    : truth_(truth), beta_goal_rad_(truth.beta_rad), motor_(start_rad) {
  if (truth.spring.k_Nm > 0.0) bend_ = spring_deflection(truth.spring, load_Nm);
  motor_ -= bend_;
  target_reading_rad_ = motor_reading_rad();
}

double Joint::counts_to_rad(double counts) const {
  return truth_.drive.sign * 2.0 * std::numbers::pi * counts / truth_.drive.counts_per_turn + truth_.drive.zero_rad;
}

double Joint::seen_rad(double place) const {
  return fault_.is_frozen ? frozen_rad_ : place - truth_.beta_rad - truth_.encoder_error.at(place) + fault_.offset_rad;
}

void Joint::set_encoder_fault(const EncoderFault& fault) {
  frozen_rad_ = reading_rad();
  fault_ = fault;
}

void Joint::block(double min_rad, double max_rad) {
  free_from_rad_ = min_rad;
  free_to_rad_ = max_rad;
}

/// The drive closes its loop on its own encoder and settles beside the target by its residual.
double Joint::behind_rad() const {
  return target_reading_rad_ + truth_.servo_residual.at(motor_) - motor_reading_rad();
}

double Joint::wanted_speed() const {
  if (mode_ != MotorMode::kFollow) return 0.0;
  const double behind = behind_rad();
  const double braking = std::sqrt(2.0 * kMaxAcceleration_rad_s2 * std::abs(behind));
  return std::copysign(std::min({std::abs(behind) / kFollowTime_s, braking, kMaxSpeed_rad_s}), behind);
}

void Joint::step(double dt_s, double load_Nm) {
  truth_.beta_rad += std::clamp(beta_goal_rad_ - truth_.beta_rad, -kCreep_rad_s * dt_s, kCreep_rad_s * dt_s);
  if (mode_ == MotorMode::kImpedance) step_impedance(dt_s, load_Nm);
  const double limit = (mode_ == MotorMode::kFollow ? kMaxAcceleration_rad_s2 : kQuickStop_rad_s2) * dt_s;
  if (mode_ != MotorMode::kImpedance) speed_ += std::clamp(wanted_speed() - speed_, -limit, limit);
  motor_ += speed_ * dt_s;
  press_on_obstacle();
  bend(dt_s, load_Nm);
  if (motor_ >= truth_.min_rad && motor_ <= truth_.max_rad) return;
  motor_ = std::clamp(motor_, truth_.min_rad, truth_.max_rad);
  speed_ = 0.0;
}

/// Drive and obstacle in balance, as two springs: the drive's is the softer by far.
void Joint::press_on_obstacle() {
  const double target = mode_ == MotorMode::kFollow ? motor_ + behind_rad() : motor_;
  const double highest = free_to_rad_ + kGive * std::max(0.0, target - free_to_rad_);
  const double lowest = free_from_rad_ + kGive * std::min(0.0, target - free_from_rad_);
  if (motor_ >= lowest && motor_ <= highest) return;
  motor_ = std::clamp(motor_, lowest, highest);
  speed_ = 0.0;
}

/// At the joint.
double Joint::impedance_torque() const {
  const double behind = target_reading_rad_ + truth_.servo_residual.at(motor_) - motor_reading_rad();
  const double lag = truth_.drive.sign * impedance_.speed_rad_s - speed_;
  const double wanted = impedance_.kp_Nm_rad * behind + impedance_.kd_Nms_rad * lag +
                        truth_.drive.sign * impedance_.torque_Nm;
  return std::clamp(wanted, -impedance_.max_torque_Nm, impedance_.max_torque_Nm);
}

void Joint::step_impedance(double dt_s, double load_Nm) {
  const double acceleration = (impedance_torque() - load_Nm - kFriction_Nms_rad * speed_) / kInertia_kg_m2;
  speed_ = std::clamp(speed_ + acceleration * dt_s, -kMaxSpeed_rad_s, kMaxSpeed_rad_s);
}

/// Damped into the balance of spring and load.
void Joint::bend(double dt_s, double load_Nm) {
  if (truth_.spring.k_Nm <= 0.0) return;
  preset_ += std::clamp(preset_goal_ - preset_, -kPresetSpeed_per_s * dt_s, kPresetSpeed_per_s * dt_s);
  Spring now = truth_.spring;
  now.preset_rad *= preset_;
  bend_ += std::min(1.0, dt_s / kSpringTime_s) * (spring_deflection(now, load_Nm) - bend_);
}

std::int32_t Joint::position_counts() {
  double reading = reading_rad() + truth_.jitter_rad * truth_.jitter.normal();
  if (fault_.tremble_rad > 0.0) reading += fault_.tremble_rad * truth_.jitter.uniform(-1.0, 1.0);
  const double turns = truth_.drive.sign * (reading - truth_.drive.zero_rad) / (2.0 * std::numbers::pi);
  return static_cast<std::int32_t>(std::lround(turns * truth_.drive.counts_per_turn));
}

std::int16_t Joint::torque_permille() const {
  if (mode_ == MotorMode::kOff) return 0;
  if (mode_ == MotorMode::kImpedance)
    return static_cast<std::int16_t>(std::lround(1e3 * truth_.drive.sign * impedance_torque() / kRatedTorque_Nm));
  const double behind = mode_ == MotorMode::kFollow ? target_reading_rad_ - motor_reading_rad() : 0.0;
  return static_cast<std::int16_t>(std::clamp(kStiffness_permille_rad * behind * truth_.drive.sign, -1000.0, 1000.0));
}

void Joint::command(MotorMode mode, std::int32_t target_counts, std::uint16_t) {
  mode_ = mode;
  target_reading_rad_ = counts_to_rad(target_counts);
}

void Joint::command(const Impedance& wanted) {
  mode_ = MotorMode::kImpedance;
  impedance_ = wanted;
  target_reading_rad_ = counts_to_rad(wanted.position_counts);
}

std::uint32_t Joint::counts_per_turn() const {
  return static_cast<std::uint32_t>(std::lround(truth_.drive.counts_per_turn / truth_.drive.gear));
}

std::uint32_t Joint::following_window_counts() const {
  return static_cast<std::uint32_t>(kFollowingWindow_rad * truth_.drive.counts_per_turn / (2.0 * std::numbers::pi));
}

}  // namespace armsight::sim
