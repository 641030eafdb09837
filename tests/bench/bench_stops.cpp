// How long an arm under way goes on when a program is gone: in simulated time, read from the simulator's truth and from
// the log of its bus, never from the controller's word.
#include <cstdio>
#include <map>

#include "tests/bench/bench_row.hpp"
#include "tests/faults/fault_rig.hpp"
#include "tests/system/quiet_arm.hpp"

namespace armsight::bench {
namespace {

constexpr double kStill_rad_s = 0.02;

/// From the kill to the last row that still moves.
Row host_lost_row() {
  Row row{"host lost -> still, powered", "ms", 0.0, {}, "", "at most 200 ms + braking (110 ms)", false, {}};
  const TemporaryFolder folder;
  demo::RunningArm arm(demo::quiet_robot(), folder.path() / "run", false);
  if (!demo::start_slow_move(arm)) return row.why = "the arm did not get under way", row;
  const double killed_s = arm.conductor().time_s();
  arm.conductor().kill("host");
  arm.conductor().run_cycles(250);
  const double finished_s = arm.conductor().time_s();
  const bool is_powered = arm.host({"status"}) == 0;
  const double asked_s = arm.conductor().time_s() - finished_s;
  const demo::Truth truth = arm.finish();
  const double end_s = 1e-9 * static_cast<double>(truth.rows.back().arm_time_ns);
  const double kill_in_trace_s = end_s - (finished_s - killed_s) - asked_s;
  const demo::TruthRow* at_kill = nullptr;
  double way_rad = 0.0;
  for (std::size_t i = 0; i + 1 < truth.rows.size(); ++i) {
    const double time_s = 1e-9 * static_cast<double>(truth.rows[i].arm_time_ns);
    if (time_s < kill_in_trace_s) continue;
    if (at_kill == nullptr) at_kill = &truth.rows[i];
    if (demo::speed_rad_s(truth, i) < kStill_rad_s) continue;
    row.ours = 1e3 * (time_s - kill_in_trace_s);
    way_rad = (truth.rows[i + 1].q_true - at_kill->q_true).cwiseAbs().maxCoeff();
  }
  // Speed over acceleration, acceleration over jerk, and the drive's own lag, at 0.6 rad/s.
  constexpr double kBraking_ms = 1e3 * (0.6 / 10.0 + 10.0 / 200.0);
  const double bound_rad = 0.6 * (0.2 + 1e-3 * kBraking_ms);
  row.holds = is_powered && row.ours > 0.0 && row.ours <= 200.0 + kBraking_ms && way_rad <= bound_rad;
  char text[96];
  std::snprintf(text, sizeof text, "way after the loss %.3f rad, bound %.3f rad at 0.6 rad/s", way_rad, bound_rad);
  row.why = text;
  return row;
}

/// From a node's last set-point to its own emergency, the slowest node.
Row controller_killed_row() {
  Row row{"controller killed -> drives start their quick stop, by RPDO deadline",
          "ms",
          0.0,
          {},
          "",
          "at most 20 ms by RPDO deadline",
          false,
          {}};
  const TemporaryFolder folder;
  demo::RunningArm arm(demo::quiet_robot(), folder.path() / "run", false);
  if (!demo::start_slow_move(arm)) return row.why = "the arm did not get under way", row;
  arm.conductor().kill("arm_controller");
  arm.conductor().run_cycles(250);
  arm.conductor().kill("host");
  arm.finish();
  std::map<unsigned, double> last_set_point, emergency;
  for (const auto& [time, interface, frame, is_error] : demo::read_bus_log(folder.path() / "run")) {
    const unsigned node = frame.id & 0x7F;
    const double time_s = 1e-9 * static_cast<double>(to_ns(time));
    if ((frame.id & 0x780) == kRpdo1Base) last_set_point[node] = time_s;
    if (demo::is_emergency(frame)) emergency.emplace(node, time_s);
  }
  for (unsigned node = 1; node <= 5; ++node) {
    if (!emergency.contains(node)) return row.why = "node " + std::to_string(node) + " reported nothing", row;
    row.ours = std::max(row.ours, 1e3 * (emergency[node] - last_set_point[node]));
  }
  row.holds = row.ours <= 20.0;
  row.why = "last set-point to EMCY on the bus, slowest of five drives";
  return row;
}

/// From the kill to the emergency of the slowest of six drives that know no deadline of set-points.
Row controller_killed_by_heartbeat_row() {
  Row row{"controller killed -> drives start their quick stop, by heartbeat", "ms", 0.0, {}, "",
          "at most 250 ms by heartbeat", false, {}};
  faults::FaultRig rig;
  for (int node = 1; node <= faults::kNodes; ++node) rig.node(node).bend({0x1400, 5}, std::nullopt);
  if (!rig.start_moving()) return row.why = "the arm did not get under way", row;
  const Time killed = rig.now;
  rig.kill_controller();
  rig.cycles(100);
  std::map<unsigned, double> emergency_ms;
  for (const faults::BusLine& line : rig.log)
    if (line.time >= killed && demo::is_emergency(line.frame))
      emergency_ms.emplace(line.frame.id & 0x7F, 1e-6 * static_cast<double>((line.time - killed).count()));
  for (const auto& [node, time_ms] : emergency_ms) row.ours = std::max(row.ours, time_ms);
  const bool all_stop = rig.all_drives(DriveState::kQuickStopActive);
  row.holds = emergency_ms.size() == faults::kNodes && all_stop && row.ours <= 250.0;
  row.why = std::to_string(emergency_ms.size()) + " of 6 drives without a deadline of their own reported it on the bus";
  return row;
}

}  // namespace

std::vector<Row> stop_rows(bool /*is_quick*/) {
  return {host_lost_row(), controller_killed_row(), controller_killed_by_heartbeat_row()};
}

}  // namespace armsight::bench
