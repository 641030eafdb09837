#include "tools/sim/plant.hpp"

#include <algorithm>
#include <cmath>

#include "shared/kinematics.hpp"
#include "tools/sim/fingers.hpp"
#include "tools/sim/joint.hpp"

namespace armsight::sim {

namespace {

constexpr std::int64_t kStep_ns = 1'000'000;
constexpr Duration kHistory = std::chrono::milliseconds(150);

struct Sample {
  Time time;
  JointVector q;
  Pose T_C_B, T_B_O;
  double closure;
};

}  // namespace

GraspRecord nearest_grasp(const Pose& T_B_H, const Pose& T_B_O, const Vector3& centre_H) {
  const Vector3 z_H = T_B_H.R.col(2);
  const double side = z_H.dot(T_B_O.R.col(2)) >= 0.0 ? 1.0 : -1.0;
  const Matrix3 tilt =
      Eigen::Quaterniond::FromTwoVectors(z_H, Vector3(side * T_B_O.R.col(2))).toRotationMatrix();
  const Vector3 p_near = T_B_O.p - tilt * T_B_H.R * centre_H;
  GraspRecord record;
  record.error_m = (T_B_H.p - p_near).norm();
  record.error_rad = so3_log(tilt).norm();
  return record;
}

struct Plant::Impl {
  Truth truth;
  GraspTruth grasp;
  Time time;
  std::vector<Joint> joints;
  std::unique_ptr<Fingers> fingers;
  SoftArm soft;
  bool feels_gravity = false;
  JointVector q;
  Pose T_B_O, T_H_O;
  std::vector<GraspRecord> grasps;
  mutable std::mutex history_mutex;
  std::deque<Sample> history;
  std::vector<Sample> newest;  ///< not yet in the history: the camera was reading it

  Pose hand() const { return forward_kinematics(truth.chain, q); }
  JointVector loads() const;
  void step(double dt_s);
  bool touch();
  void remember();
};

Plant::Plant(const RobotConfig& robot, const Scene& scene, Truth truth, Time start) : impl_(new Impl) {
  Impl& plant = *impl_;
  plant.truth = std::move(truth);
  plant.grasp = scene.grasp;
  plant.time = start;
  plant.T_B_O = plant.truth.T_B_O;
  plant.q = plant.truth.start_rad;
  plant.soft = robot.soft;
  const auto gives_way = [](const DriveConfig& drive) { return drive.family == DriveFamily::kDamiao; };
  plant.feels_gravity = robot.soft.has_springs() || std::ranges::any_of(robot.drives, gives_way);
  const JointVector load = plant.loads();
  const NoiseFigures figures = noise_figures(plant.truth.noise);
  for (int i = 0; i < robot.arm.joint_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    JointTruth joint;
    joint.drive = robot.drives[k];
    joint.beta_rad = plant.truth.beta[i];
    joint.encoder_error = plant.truth.encoder_error[k];
    joint.servo_residual = plant.truth.servo_residual[k];
    joint.jitter_rad = figures.encoder_jitter_rad;
    joint.jitter = Random(plant.truth.seed, kForJitter, k);
    joint.spring = robot.soft.springs[k];
    joint.min_rad = robot.arm.limits.min_rad[i] - kMechanicalMargin_rad;
    joint.max_rad = robot.arm.limits.max_rad[i] + kMechanicalMargin_rad;
    plant.joints.emplace_back(joint, plant.q[i], load[i]);
  }
  plant.fingers = std::make_unique<Fingers>(robot.hand, [this] { return impl_->touch(); });
  plant.remember();
}

Plant::~Plant() = default;

bool Plant::Impl::touch() {
  GraspRecord record = nearest_grasp(hand(), T_B_O, grasp.centre_H);
  record.time = time;
  record.is_held = record.error_m <= grasp.tolerance_m && record.error_rad <= grasp.tolerance_rad;
  grasps.push_back(record);
  if (record.is_held) T_H_O = hand().inverse() * T_B_O;
  return record.is_held;
}

/// What the links need to be held; nobody asks where neither spring nor impedance gives way.
JointVector Plant::Impl::loads() const {
  if (!feels_gravity) return JointVector::Zero(q.size());
  return gravity_torque(truth.chain, soft.links, soft.gravity_m_s2, q);
}

void Plant::Impl::step(double dt_s) {
  const JointVector load = loads();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].step(dt_s, load[static_cast<Eigen::Index>(i)]);
    q[static_cast<Eigen::Index>(i)] = joints[i].q_rad();
  }
  fingers->step(dt_s);
  if (fingers->is_holding()) T_B_O = hand() * T_H_O;
}

void Plant::Impl::remember() {
  newest.push_back({time, q, truth.T_C_B, T_B_O, fingers->closure()});
  const std::unique_lock lock(history_mutex, std::try_to_lock);  // the bus never waits for the camera
  if (!lock) return;
  history.insert(history.end(), newest.begin(), newest.end());
  newest.clear();
  while (history.front().time + kHistory < time) history.pop_front();
}

void Plant::advance_to(Time to) {
  Impl& plant = *impl_;
  while (plant.time < to) {
    const std::int64_t grid_ns = (to_ns(plant.time) / kStep_ns + 1) * kStep_ns;
    const Time next = std::min(to, time_from_ns(grid_ns));
    const double dt_s = to_seconds(next - plant.time);
    plant.time = next;
    plant.step(dt_s);
    plant.remember();
  }
}

void Plant::inject_drift() {
  Impl& plant = *impl_;
  armsight::sim::inject_drift(plant.truth);
  for (std::size_t i = 0; i < plant.joints.size(); ++i)
    plant.joints[i].set_beta(plant.truth.beta[static_cast<Eigen::Index>(i)]);
}

void Plant::set_encoder_fault(int joint, const EncoderFault& fault) {
  impl_->joints[static_cast<std::size_t>(joint)].set_encoder_fault(fault);
}

void Plant::block(int joint, double min_rad, double max_rad) {
  impl_->joints[static_cast<std::size_t>(joint)].block(min_rad, max_rad);
}

Motor& Plant::joint_motor(int i) { return impl_->joints[static_cast<std::size_t>(i)]; }
Motor& Plant::hand_motor() { return *impl_->fingers; }
const JointVector& Plant::q_real() const { return impl_->q; }
double Plant::speed_rad_s(int joint) const { return impl_->joints[static_cast<std::size_t>(joint)].speed_rad_s(); }
Pose Plant::T_B_H() const { return impl_->hand(); }
double Plant::hand_closure() const { return impl_->fingers->closure(); }
const Truth& Plant::truth() const { return impl_->truth; }
const std::vector<GraspRecord>& Plant::grasps() const { return impl_->grasps; }

WorldView Plant::view(double time_s) const {
  const Impl& plant = *impl_;
  Sample at;
  {
    const std::lock_guard lock(plant.history_mutex);
    const auto& history = plant.history;
    const Time time = seconds_to_duration(time_s) + Time{};
    const auto after = std::find_if(history.begin(), history.end(), [time](const Sample& s) { return s.time > time; });
    at = after == history.end() ? history.back() : *(after == history.begin() ? after : after - 1);
    if (after != history.begin() && after != history.end()) {
      const double part = to_seconds(time - at.time) / to_seconds(after->time - at.time);
      at.q += part * (after->q - at.q);
      at.closure += part * (after->closure - at.closure);
    }
  }
  return {time_s, at.T_C_B, forward_kinematics(plant.truth.chain, at.q), plant.truth.T_H_M, at.T_B_O, at.closure};
}

}  // namespace armsight::sim
