// The filter's update and the whole cycle of the controller on scripted drives.
#include "shared/joint_offset_ekf.hpp"
#include "shared/joint_servo.hpp"
#include "tests/arm_controller/arm_rig.hpp"
#include "tests/bench/bench_row.hpp"
#include "tests/shared/default_arm.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace armsight::bench {
namespace {

using namespace test;

constexpr std::size_t kRounds = 1000;

Row filter_row(const std::string& name, int max_iterations, double most_us, int blocks) {
  std::mt19937 random(1);
  const TrueRobot truth = true_robot(random);
  EkfOptions options;
  options.max_iterations = max_iterations;
  std::vector<HandPoseMeasurement> looks;
  std::vector<JointOffsetEkf> starts;
  for (std::size_t i = 0; i < kRounds; ++i) {
    looks.push_back(look_at(truth, random_visible_posture(truth, random), {}, false, random));
    looks.back().has_second = false;
    starts.emplace_back(truth.arm.chain, options);
    starts.back().reset(disturbed_model(truth, 0.03, 0.07, 0.05, 0.0087, random));
  }
  JointOffsetEkf ekf = starts.front();
  std::size_t fused = 0, iterations = 0;
  for (std::size_t i = 0; i < kRounds; ++i) {
    ekf = starts[i];
    const FusionReport report = ekf.update(looks[i]);
    fused += report.outcome == FusionOutcome::kFused ? 1 : 0;
    iterations += static_cast<std::size_t>(report.iterations);
  }
  const Paired time = time_paired(kRounds, blocks, [&](std::size_t i) {
    ekf = starts[i];
    keep(ekf.update(looks[i]));
  });
  Row row{name, "us", time.ours_us, {}, "", "at most " + std::to_string(int(most_us)) + " us", {}, {}};
  row.holds = fused > kRounds / 2 && time.ours_us <= most_us;
  row.why = std::to_string(fused) + " of " + std::to_string(kRounds) + " looks fused, " +
            std::to_string(static_cast<double>(iterations) / kRounds).substr(0, 4) + " inner steps on average";
  return row;
}

/// Another target every cycle, so a new plan from motion each time: the dearest step.
Row joint_servo_row(int blocks) {
  const ArmModel arm = default_arm();
  std::mt19937 random(3);
  std::vector<JointVector> targets;
  for (std::size_t i = 0; i < kRounds; ++i) targets.push_back(random_within(arm.limits, random));
  JointServo servo(arm.limits);
  servo.reset(joints({0.3, -0.4, 0.5, 1.0, 0.2}));
  const Paired time =
      time_paired(kRounds, blocks, [&](std::size_t i) { keep(servo.step_towards(targets[i], 1.0, 0.004)); });
  return {"jerk-limited joint servo, five joints, a new target every cycle", "us", time.ours_us, {}, "", "", {}, {}};
}

/// Cycles under way between far postures; every tenth carries a look, as many as a busy `adapt` would send in a second.
std::vector<double> cycle_times_us(int cycles) {
  arm::test::ArmRig rig;
  std::vector<double> times;
  if (!rig.power_up()) return times;
  const Pose T_C_B = rig.robot.camera_hint_T_C_B;
  std::uint64_t id = 100;
  double turn = 0.2;
  for (int k = 0; k < cycles; ++k) {
    if (rig.state.mode == arm::Mode::kHold && k % 50 == 0) {
      turn = -turn;
      rig.mailboxes.goal.put(rig.joint_goal(++id, rig.q_reading() + JointVector::Constant(5, turn)));
    }
    if (k % 10 == 0) {
      arm::Look look;
      look.tag = {7, ++id};
      look.capture_time = rig.now - std::chrono::milliseconds(8);
      look.measurement.T_C_H = predict_T_C_H(rig.robot.arm.chain, T_C_B, JointVector::Zero(5), rig.q_reading());
      look.measurement.R_vision = 1e-6 * Matrix6::Identity();
      look.measurement.q = rig.q_reading();
      rig.mailboxes.looks.push(look);
    }
    rig.now += seconds_to_duration(rig.robot.controller.period_s);
    rig.bus.now = rig.now;
    rig.mailboxes.lease.put({7, rig.now + std::chrono::seconds(1)});
    const double start = thread_time_us();
    rig.loop->cycle(rig.now, 0);
    times.push_back(thread_time_us() - start);
    if (const auto newest = rig.mailboxes.state.take()) rig.state = *newest;
    arm::Event event;
    while (rig.mailboxes.events.pop(event)) {
    }
    while (rig.tape.events.pop(event)) {
    }
    arm::TickRecord record;
    while (rig.tape.ticks.pop(record)) {
    }
  }
  return times;
}

std::vector<Row> tick_rows(int cycles) {
  std::vector<double> times = cycle_times_us(cycles);
  const auto row = [&](const char* name, double fraction, double most_us) {
    Row r{name, "us", 0.0, {}, "", "at most " + std::to_string(int(most_us)) + " us", false, {}};
    if (times.empty()) {
      r.why = "the scripted drives did not come up";
      return r;
    }
    std::sort(times.begin(), times.end());
    r.ours = times[static_cast<std::size_t>(fraction * static_cast<double>(times.size() - 1))];
    r.holds = r.ours <= most_us;
    r.why = std::to_string(times.size()) + " cycles; a look in every tenth";
    return r;
  };
  return {row("whole tick incl. decode, history, EKF predict, servo, encode, p50", 0.5, 10.0),
          row("whole tick incl. decode, history, EKF predict, servo, encode, p99.9", 0.999, 50.0)};
}

}  // namespace

std::vector<Row> controller_rows(bool is_quick) {
  const int blocks = is_quick ? 3 : 41;
  std::vector<Row> rows{filter_row("EKF update (11 states, <= 5 inner iterations)", 5, 25.0, blocks),
                        filter_row("EKF update, single iteration", 1, 5.0, blocks), joint_servo_row(blocks)};
  for (const Row& row : tick_rows(is_quick ? 2000 : 100000)) rows.push_back(row);
  return rows;
}

}  // namespace armsight::bench
