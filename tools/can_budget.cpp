// Does the arm's traffic fit on its buses? Worst case from the robot file, beside what a recording or a running bus
// shows. Exit codes: 0 fits, 1 does not fit, 2 bad flag or file, 3 bus lost.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <vector>

#include "arm_controller/emulated_bus.hpp"
#include "arm_controller/socket_can.hpp"
#include "protocol/bus_budget.hpp"
#include "protocol/bus_traffic.hpp"
#include "protocol/candump.hpp"
#include "protocol/transport/wait.hpp"
#include "tools/command_line.hpp"

namespace {

using namespace armsight;

constexpr std::array kUsualRates_hz{250.0, 500.0, 1000.0};
constexpr double kErrorFrameBits = 31;  // and the frame again (controller.md §3.2)

volatile std::sig_atomic_t is_stopping = 0;
void stop(int) { is_stopping = 1; }

struct Seen {
  std::string name;
  BusTraffic traffic;
};
using SeenBuses = std::vector<Seen>;

/// The interfaces of a log, in order of their names, are bus 0, bus 1 …
SeenBuses read_log(const std::string& file, const BusRates& rates) {
  std::ifstream in(file);
  if (!in) throw ConfigError(file + ": cannot be read");
  SeenBuses out;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.empty()) continue;
    const CandumpResult result = parse_candump(text);
    if (!result.line) throw ConfigError(file + ":" + std::to_string(number) + ": " + result.why);
    if (result.line->is_error_frame) continue;
    const std::string& name = result.line->interface;
    auto bus = std::ranges::find(out, name, &Seen::name);
    if (bus == out.end()) bus = out.insert(out.end(), {name, BusTraffic(rates)});
    bus->traffic.add(result.line->frame, result.line->time);
  }
  if (out.empty()) throw ConfigError(file + ": holds no frame");
  std::ranges::sort(out, {}, &Seen::name);
  return out;
}

Seen listen_to_emulated(const std::string& path, double seconds, const BusRates& rates) {
  arm::BusObserver bus(path);
  Seen out{"emulated:" + path, BusTraffic(rates)};
  arm::BusFrame frame;
  const auto end = std::chrono::steady_clock::now() + seconds_to_duration(seconds);
  while (is_stopping == 0 && std::chrono::steady_clock::now() < end) {
    if (!bus.is_open()) throw arm::BusError("emulated bus " + path + " is lost");
    if (bus.receive(frame, std::chrono::milliseconds(100))) out.traffic.add(frame.frame, frame.time);
  }
  return out;
}

Seen listen_to_interface(const std::string& name, double seconds, const BusRates& rates) {
  const auto clock = net::make_monotonic_clock(std::chrono::milliseconds(1));
  const auto bus = arm::open_socket_can(name, *clock, arm::CanHears::kEverything);
  const std::vector<int> descriptor{bus->descriptor()};
  Seen out{name, BusTraffic(rates)};
  arm::BusFrame frame;
  const Time end = clock->now() + seconds_to_duration(seconds);
  while (is_stopping == 0 && clock->now() < end) {
    while (bus->receive(frame)) out.traffic.add(frame.frame, frame.time);
    if (bus->take_errors().lost) throw arm::BusError(name + " is lost");
    net::wait_and_flow(descriptor, std::chrono::milliseconds(100), nullptr);
  }
  return out;
}

void print_seen(const BusTraffic& traffic, const SeenMessage& seen) {
  const auto count = static_cast<double>(std::max<std::uint64_t>(seen.count, 1));
  std::printf(" | %8.1f %6.1f %4d", static_cast<double>(seen.count) / traffic.duration_s(),
              static_cast<double>(seen.bits) / count, seen.most_bits);
}

void print_message(const BusMessage& message, const Seen* seen) {
  std::printf("  %-30s 0x%03X %4d %8.1f %7.2f", message.name.c_str(), message.id, message.bits, 1.0 / message.period_s,
              100.0 * message.wire_s / message.period_s);
  if (message.latest_s) std::printf(" %9.0f", 1e6 * *message.latest_s);
  else std::printf(" %9s", "unbounded");
  if (seen != nullptr) {
    const auto found = seen->traffic.messages().find(message.id);
    if (found == seen->traffic.messages().end()) {
      std::printf(" | %8s", "none");
    } else {
      print_seen(seen->traffic, found->second);
      if (message.is_cyclic && found->second.latest_s) std::printf(" %9.0f", 1e6 * *found->second.latest_s);
    }
  }
  std::printf("\n");
}

/// Traffic that no single line above stands for: SDO and EMCY of each node, and what is not ours.
void print_others(const BusBudget& budget, const Seen& seen) {
  for (const auto& [id, message] : seen.traffic.messages()) {
    const bool has_line = std::ranges::any_of(budget.messages, [id = id](const BusMessage& m) { return m.id == id; });
    if (has_line || message.count == 0) continue;
    std::printf("  %-30s 0x%03X %4s %8s %7s %9s", "", id, "", "", "", "");
    print_seen(seen.traffic, message);
    std::printf("\n");
  }
}

void print_bus(const BusBudget& budget, const RobotConfig& robot, double period_s, const Seen* seen) {
  std::printf("bus %d: %d nodes, %.0f kbit/s, %.4g Hz\n", budget.bus, budget.node_count,
              1e-3 * robot.controller.bus_bitrate_bit_s, 1.0 / period_s);
  std::printf("  %-30s %5s %4s %8s %7s %9s", "message, worst case", "id", "bits", "per s", "load %", "latest us");
  if (seen != nullptr) std::printf(" | %8s %6s %4s %9s", "seen/s", "bits", "most", "latest us");
  std::printf("\n");
  for (const BusMessage& message : budget.messages) print_message(message, seen);
  if (seen != nullptr) print_others(budget, *seen);
  const double slack_s = period_s - budget.cycle_s;
  const double again_s = (kErrorFrameBits + worst_case_bits(8)) / robot.controller.bus_bitrate_bit_s;
  std::printf("  worst case: load %.1f %%; a cycle's frames take %.0f us of %.0f", 100 * budget.load,
              1e6 * budget.cycle_s, 1e6 * period_s);
  if (slack_s > 0) std::printf(", room for %d frames sent again\n", static_cast<int>(slack_s / again_s));
  else std::printf(": too long\n");
  if (seen == nullptr) return;
  const BusTraffic& traffic = seen->traffic;
  std::printf("  measured on %s, %.2f s: load %.1f %%, %.1f %% in the fullest 0.1 s, %.1f %% at most\n",
              seen->name.c_str(), traffic.duration_s(), 100 * traffic.load(), 100 * traffic.highest_load(),
              100 * traffic.worst_case_load());
}

void print_rates(const RobotConfig& robot) {
  std::printf("rates:");
  for (const double rate : kUsualRates_hz) {
    std::printf("%s %.0f Hz %.1f %%", rate == kUsualRates_hz.front() ? "" : ",", rate,
                100 * highest_load(bus_budgets(robot, 1.0 / rate)));
    const auto buses = buses_needed(robot, 1.0 / rate);
    if (buses) std::printf(" (needs %d bus%s)", *buses, *buses > 1 ? "es" : "");
    else std::printf(" (no number of such buses)");
  }
  std::printf("\n");
}

int judge(const RobotConfig& robot) {
  const double limit = robot.controller.bus_load_limit;
  if (const std::string rule = broken_load_rule(robot); !rule.empty()) {
    std::printf("can_budget: DOES NOT FIT: %.4g Hz: %s\n", 1.0 / robot.controller.period_s, rule.c_str());
    return 1;
  }
  const double shortest_s = shortest_period_s(robot).value();
  std::printf("can_budget: fits: %.4g Hz loads the fullest bus to %.1f %%, limit %.4g %%; the highest rate that fits "
              "is %.4g Hz (period_s %.4g)\n", 1.0 / robot.controller.period_s, 100 * highest_load(bus_budgets(robot)),
              100 * limit, 1.0 / shortest_s, shortest_s);
  return 0;
}

int judge_measured(const RobotConfig& robot, const SeenBuses& seen) {
  int code = 0;
  for (const Seen& bus : seen) {
    if (bus.traffic.highest_load() <= robot.controller.bus_load_limit) continue;
    std::printf("can_budget: DOES NOT FIT: %s was loaded to %.1f %% for 0.1 s\n", bus.name.c_str(),
                100 * bus.traffic.highest_load());
    code = 1;
  }
  return code;
}

int run(const RobotConfig& robot, const SeenBuses& seen) {
  const std::vector<BusBudget> budgets = bus_budgets(robot);
  if (seen.size() > budgets.size())
    throw ConfigError("the traffic is of " + std::to_string(seen.size()) + " buses, the robot file has " +
                      std::to_string(budgets.size()));
  for (std::size_t i = 0; i < budgets.size(); ++i)
    print_bus(budgets[i], robot, robot.controller.period_s, i < seen.size() ? &seen[i] : nullptr);
  print_rates(robot);
  return std::max(judge_measured(robot, seen), judge(robot));
}

}  // namespace

int main(int argc, char** argv) {
  tools::CommandLine line("Does the arm's traffic fit on its CAN buses: worst case from the robot file, latest "
                          "response of every message, and what a recording or a running bus shows beside it.",
                          "can_budget");
  std::string robot_file, log;
  std::vector<std::string> buses, interfaces;
  std::optional<double> rate_hz, seconds;
  line.add("--robot", robot_file, "robot file").required();
  line.add("--rate", rate_hz, "cycles a second, instead of the robot file's").between(10.0, 1000.0);
  line.add("--log", log, "candump -L text, e.g. of arm_sim --log; its interfaces by name are bus 0, 1 …");
  line.add("--bus", buses, "emulated:PATH: listen to the bus that arm_sim serves; once a bus, in order");
  line.add("--can", interfaces, "listen to a CAN interface of this machine; once a bus, in order");
  line.add("--seconds", seconds, "how long to listen, to one bus after the other (5)").positive();
  if (const auto code = line.parse(argc, argv)) return *code;
  const std::string prefix = "emulated:";
  const int sources = int{!log.empty()} + int{!buses.empty()} + int{!interfaces.empty()};
  const auto is_emulated = [&prefix](const std::string& bus) { return bus.starts_with(prefix); };
  if (sources > 1 || !std::ranges::all_of(buses, is_emulated)) {
    std::fprintf(stderr, "can_budget: give at most one of --log FILE, --bus emulated:PATH and --can IFACE\n");
    return 2;
  }
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  try {
    RobotConfig robot = load_robot(robot_file);
    if (rate_hz) robot.controller.period_s = 1.0 / *rate_hz;
    if (const char* rule = broken_period_rule(robot.controller.period_s))
      throw ConfigError("--rate " + std::to_string(*rate_hz) + ": the period " + rule);
    const BusRates rates = bus_rates(robot);
    SeenBuses seen;
    if (!log.empty()) seen = read_log(log, rates);
    const double each_s = seconds.value_or(5.0);
    for (const std::string& bus : buses) seen.push_back(listen_to_emulated(bus.substr(prefix.size()), each_s, rates));
    for (const std::string& name : interfaces) seen.push_back(listen_to_interface(name, each_s, rates));
    return run(robot, seen);
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "can_budget: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "can_budget: %s\n", error.what());
    return 3;
  }
}
