// What the hot functions of shared/ cost: `ninja bench_shared && bin/bench_shared`. Compare with controller.md §6.2 and
// specification F-F1 (update ≤ 25 µs, single step ≤ 5 µs).
#include <benchmark/benchmark.h>

#include <array>

#include "shared/inverse_kinematics.hpp"
#include "shared/joint_offset_ekf.hpp"
#include "shared/joint_servo.hpp"
#include "shared/pose_servo.hpp"
#include "tests/shared/default_arm.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace armsight {
namespace {

using namespace test;

const JointVector kPosture = joints({0.3, -0.4, 0.5, 1.0, 0.2});

void forward_kinematics_and_jacobian(benchmark::State& state) {
  const SerialChain chain = default_arm().chain;
  for (auto _ : state) benchmark::DoNotOptimize(hand_kinematics(chain, kPosture));
}
BENCHMARK(forward_kinematics_and_jacobian);

/// range: inner steps allowed.
void filter_update(benchmark::State& state) {
  std::mt19937 random(1);
  const TrueRobot truth = true_robot(random);
  EkfOptions options;
  options.max_iterations = static_cast<int>(state.range(0));
  JointOffsetEkf ekf(truth.arm.chain, options);
  ekf.reset(disturbed_model(truth, 0.03, 0.07, 0.05, 0.0087, random));
  const JointOffsetEkf start = ekf;
  HandPoseMeasurement z = look_at(truth, random_visible_posture(truth, random), {}, false, random);
  z.has_second = false;
  for (auto _ : state) {
    ekf = start;
    benchmark::DoNotOptimize(ekf.update(z));
  }
}
BENCHMARK(filter_update)->Arg(1)->Arg(5);

void inverse_kinematics_of_a_reachable_pose(benchmark::State& state) {
  const ArmModel arm = default_arm();
  std::mt19937 random(2);
  for (auto _ : state) {
    const Pose goal = forward_kinematics(arm.chain, random_within(arm.limits, random));
    benchmark::DoNotOptimize(solve_ik(arm.chain, arm.limits.min_rad, arm.limits.max_rad, goal, kPosture));
  }
}
BENCHMARK(inverse_kinematics_of_a_reachable_pose);

void joint_servo_step(benchmark::State& state) {
  const ArmModel arm = default_arm();
  JointServo servo(arm.limits);
  servo.reset(kPosture);
  bool up = true;
  for (auto _ : state) {
    const JointVector& target = up ? arm.limits.max_rad : arm.limits.min_rad;
    benchmark::DoNotOptimize(servo.step_towards(target, 1.0, 0.004));
    if (servo.is_at_rest()) up = !up;
  }
}
BENCHMARK(joint_servo_step);

/// Another target every cycle, so a new plan from motion: the dearest step.
void joint_servo_step_to_a_new_target(benchmark::State& state) {
  const ArmModel arm = default_arm();
  std::mt19937 random(3);
  std::array<JointVector, 1024> targets;
  for (JointVector& target : targets) target = random_within(arm.limits, random);
  JointServo servo(arm.limits);
  servo.reset(kPosture);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(servo.step_towards(targets[++i % targets.size()], 1.0, 0.004));
}
BENCHMARK(joint_servo_step_to_a_new_target);

void joint_servo_step_with_speed(benchmark::State& state) {
  const ArmModel arm = default_arm();
  std::mt19937 random(4);
  std::array<JointVector, 1024> speeds;
  for (JointVector& speed : speeds)
    speed = random_between(-arm.limits.max_speed_rad_s, arm.limits.max_speed_rad_s, random);
  JointServo servo(arm.limits);
  servo.reset(kPosture);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(servo.step_with_speed(speeds[++i % speeds.size()], 0.004));
}
BENCHMARK(joint_servo_step_with_speed);

void pose_servo_step(benchmark::State& state) {
  const ArmModel arm = default_arm();
  const Pose goal = forward_kinematics(arm.chain, joints({0.5, -0.3, 0.2, 1.2, -0.4}));
  for (auto _ : state) {
    benchmark::DoNotOptimize(pose_servo_speeds(arm.chain, kPosture, goal, arm.limits.min_rad, arm.limits.max_rad,
                                               arm.limits.max_speed_rad_s, 0.004, {}));
  }
}
BENCHMARK(pose_servo_step);

}  // namespace
}  // namespace armsight
