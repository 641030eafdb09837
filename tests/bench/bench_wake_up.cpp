// How late the cycle wakes at 500 Hz under SCHED_FIFO, beside cyclictest (package rt-tests): both programs in turn,
// 10 s each, on the same CPU at the same period and priority, so that what else the machine does meets both.
#include <sched.h>

#include <cinttypes>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "arm_controller/real_time.hpp"
#include "tests/bench/bench_row.hpp"
#include "tests/system/quiet_arm.hpp"

namespace armsight::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kPeriod_ns = 2'000'000;
constexpr double kMost_us = 150.0, kMostOfPeer = 1.5;

/// How often a wake-up was how late.
struct WakeUps {
  std::map<std::int64_t, std::uint64_t> count_at_ns;

  std::uint64_t count() const {
    std::uint64_t sum = 0;
    for (const auto& [late_ns, count] : count_at_ns) sum += count;
    return sum;
  }
  std::uint64_t a_period_late() const {
    std::uint64_t sum = 0;
    for (const auto& [late_ns, count] : count_at_ns) sum += late_ns >= kPeriod_ns ? count : 0;
    return sum;
  }
  double quantile_us(double share) const {
    std::uint64_t left = count() - static_cast<std::uint64_t>(share * static_cast<double>(count()));
    for (auto at = count_at_ns.rbegin(); at != count_at_ns.rend(); ++at) {
      if (at->second >= left) return 1e-3 * static_cast<double>(at->first);
      left -= at->second;
    }
    return 0.0;
  }
};

struct Cpus {
  int cycle = 0;
  std::string others;  ///< as taskset takes them; empty: there is but one
};

/// The last one is the cycle's; what plays the arm runs elsewhere, as the arm does.
Cpus choose_cpus() {
  cpu_set_t allowed;
  sched_getaffinity(0, sizeof allowed, &allowed);
  Cpus cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &allowed)) cpus.cycle = cpu;
  for (int cpu = 0; cpu < cpus.cycle; ++cpu)
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &allowed))
      cpus.others += (cpus.others.empty() ? "" : ",") + std::to_string(cpu);
  return cpus;
}

/// Why there is no real-time priority here; empty: there is.
std::string refusal_of_fifo() {
  std::string sentence;
  std::thread([&] {
    for (const arm::NotGranted& item : arm::become_real_time(std::nullopt)) sentence = item.sentence;
  }).join();
  return sentence;
}

/// Adds the controller's own histogram of one run, bring-up included. False: it told none.
bool add_ours(const Cpus& cpus, int seconds, WakeUps& sum) {
  const TemporaryFolder folder;
  demo::DemoOptions options = demo::quiet_robot();
  options.pace = "real";
  const fs::path robot = folder.path() / "robot.yaml", figures = folder.path() / "status.json";
  demo::write_changed_robot(options.robot_file, robot, {{"period_s: 0.004", "period_s: 0.002"}});
  options.robot_file = robot;
  options.controller_flags = {"--cpu", std::to_string(cpus.cycle), "--require-rt"};
  if (!cpus.others.empty()) options.tracers["arm_sim"] = {"/usr/bin/env", "taskset", "--cpu-list", cpus.others};
  demo::RunningArm arm(options, folder.path() / "run", false);
  arm.host({"enable"});
  arm.conductor().run_cycles(static_cast<std::uint64_t>(seconds) * 250);
  arm.host({"status", "--out", figures.string()});
  std::ifstream in(figures);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object()) return false;
  for (const auto& row : json["durations"]) {
    if (row["name"] != "wake-up late") continue;
    for (std::size_t i = 0; i < row["counts"].size(); ++i)
      sum.count_at_ns[row["upper_ns"][i].get<std::int64_t>()] += row["counts"][i].get<std::uint64_t>();
  }
  return true;
}

void add_cyclictest(const Cpus& cpus, int seconds, WakeUps& sum) {
  constexpr int kLongest_us = 20'000;
  char command[256];
  std::snprintf(command, sizeof command,
                "cyclictest --mlockall --quiet --threads=1 --affinity=%d --priority=%d --interval=%d --duration=%d "
                "--histogram=%d 2>&1",
                cpus.cycle, arm::kCyclePriority, static_cast<int>(kPeriod_ns / 1000), seconds, kLongest_us);
  std::istringstream lines(output_of(command));
  for (std::string line; std::getline(lines, line);) {
    std::int64_t late_us = 0;
    std::uint64_t count = 0;
    if (std::sscanf(line.c_str(), "%" SCNd64 " %" SCNu64, &late_us, &count) == 2 && count > 0)
      sum.count_at_ns[1000 * late_us] += count;
    if (std::sscanf(line.c_str(), "# Histogram Overflows: %" SCNu64, &count) == 1 && count > 0)
      sum.count_at_ns[1000 * (kLongest_us + 1)] += count;
  }
}

std::string in_words(const WakeUps& ours, const WakeUps& peer, const Cpus& cpus) {
  double load = 0.0;
  ::getloadavg(&load, 1);
  char text[256];
  std::snprintf(text, sizeof text,
                "%" PRIu64 " cycles, p50 %.0f us, longest %.0f us, a period late %" PRIu64 "; cyclictest %" PRIu64
                ", %.0f us, %.0f us, %" PRIu64 "; CPU %d, load average %.1f",
                ours.count(), ours.quantile_us(0.5), ours.quantile_us(1.0), ours.a_period_late(), peer.count(),
                peer.quantile_us(0.5), peer.quantile_us(1.0), peer.a_period_late(), cpus.cycle, load);
  return text;
}

Row wake_up_row(bool is_quick) {
  Row row{"500 Hz under SCHED_FIFO, --pace real, wake-up p99.9", "us", 0.0, {}, "",
          "at most 150 us or 1.5 times cyclictest's; none a period late that cyclictest has not", false, {}};
  if (const std::string refused = refusal_of_fifo(); !refused.empty()) return row.why = "not run: " + refused, row;
  if (output_of("command -v cyclictest").empty()) return row.why = "not run: no cyclictest (package rt-tests)", row;
  const Cpus cpus = choose_cpus();
  WakeUps ours, peer;
  for (int slice = 0; slice < (is_quick ? 1 : 20); ++slice) {
    if (!add_ours(cpus, is_quick ? 1 : 10, ours)) return row.why = "the controller told no durations", row;
    add_cyclictest(cpus, is_quick ? 1 : 10, peer);
  }
  if (peer.count() == 0) return row.why = "not run: cyclictest counted nothing", row;
  row.ours = ours.quantile_us(0.999);
  row.peer = peer.quantile_us(0.999);
  row.peer_name = "cyclictest";
  const bool is_on_time = row.ours <= kMost_us || row.ours <= kMostOfPeer * *row.peer;
  row.holds = is_on_time && (ours.a_period_late() == 0 || peer.a_period_late() > 0);
  row.why = in_words(ours, peer, cpus);
  return row;
}

}  // namespace

std::vector<Row> wake_up_rows(bool is_quick) { return {wake_up_row(is_quick)}; }

}  // namespace armsight::bench
