#include "protocol/bus_budget.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace armsight {

namespace {

constexpr double kHeartbeat_s = 0.1;      // 0x1017 and our own
constexpr double kSdoExchange_s = 0.05;   // 20 a second
constexpr double kEmergency_s = 0.2;      // 5 a second
constexpr int kWhole = 8, kHeartbeatSize = 1, kSyncSize = 1;
constexpr double kLongestPeriod_s = 0.1, kShortestPeriod_s = 0.001;
constexpr double kPeriodStep_s = 0.0001;  // the finer unit of 0x60C2
constexpr double kRounding = 1e-9;

struct Wire {
  BusRates rates;
  double period_s;
};

/// A drive as the bus sees it.
struct Talker {
  std::uint8_t node = 0;
  const MitConfig* mit = nullptr;  ///< of a DAMIAO drive
};
using Talkers = std::vector<Talker>;

class Messages {
 public:
  explicit Messages(const Wire& wire) : wire_(wire) {}

  void cyclic(const std::string& name, std::uint32_t id, int size, bool is_fd = false) {
    add(name, id, size, is_fd, wire_.period_s, true);
  }
  void sporadic(const std::string& name, std::uint32_t id, int size, double period_s, bool is_fd = false) {
    add(name, id, size, is_fd, period_s, false);
  }
  std::vector<BusMessage> in_order() {
    std::ranges::stable_sort(all_, {}, &BusMessage::id);
    return std::move(all_);
  }

 private:
  void add(const std::string& name, std::uint32_t id, int size, bool is_fd, double period_s, bool is_cyclic) {
    const FdBits fd = worst_case_fd_bits(size);
    const int bits = is_fd ? fd.arbitration + fd.data : worst_case_bits(size);
    all_.push_back({name, id, bits, worst_case_s(size, is_fd, wire_.rates), period_s, is_cyclic, std::nullopt});
  }
  Wire wire_;
  std::vector<BusMessage> all_;
};

// One of all nodes may be in trouble or be asked at a time: the allowance is the bus', whoever uses it.
void add_canopen(Messages& out, const std::vector<std::uint8_t>& nodes) {
  if (nodes.empty()) return;
  out.cyclic("SYNC", kSyncId, kSyncSize);
  out.sporadic("EMCY, any node", kEmcyBase + nodes.front(), kWhole, kEmergency_s);
  out.sporadic("SDO answer, any node", kSdoAnswerBase + nodes.front(), kWhole, kSdoExchange_s);
  out.sporadic("SDO request, any node", kSdoRequestBase + nodes.front(), kWhole, kSdoExchange_s);
  for (const std::uint8_t node : nodes) {
    const std::string of = " of node " + std::to_string(node);
    out.cyclic("TPDO1" + of, kTpdo1Base + node, kWhole);
    out.cyclic("RPDO1" + of, kRpdo1Base + node, kWhole);
    out.sporadic("heartbeat" + of, kHeartbeatBase + node, kHeartbeatSize, kHeartbeat_s);
  }
  out.sporadic("heartbeat of the controller", kHeartbeatBase + kControllerNode, kHeartbeatSize, kHeartbeat_s);
}

void add_damiao(Messages& out, const Talkers& motors) {
  for (const Talker& motor : motors) {
    const std::string of = " of motor " + std::to_string(motor.node);
    out.cyclic("command" + of, motor.node, kWhole, motor.mit->is_fd);
    out.cyclic("sample" + of, motor.mit->reply_id, kWhole, motor.mit->is_fd);
  }
  if (motors.empty()) return;
  const MitConfig& first = *motors.front().mit;
  out.sporadic("register answer, any motor", first.reply_id, kWhole, kSdoExchange_s, first.is_fd);
  out.sporadic("register request, any motor", kMitRegisterId, kWhole, kSdoExchange_s, first.is_fd);
}

std::vector<BusMessage> messages_of(const Talkers& talkers, const Wire& wire) {
  std::vector<std::uint8_t> nodes;
  Talkers motors;
  for (const Talker& talker : talkers) {
    if (talker.mit == nullptr) nodes.push_back(talker.node);
    else motors.push_back(talker);
  }
  Messages out(wire);
  add_canopen(out, nodes);
  add_damiao(out, motors);
  return out.in_order();
}

/// Longest time that a lower priority can hold the bus: it is not interrupted.
double blocking_s(const std::vector<BusMessage>& messages, std::size_t m) {
  double longest = 0.0;
  for (std::size_t k = m + 1; k < messages.size(); ++k) longest = std::max(longest, messages[k].wire_s);
  return longest;
}

/// What messages 0 … last_included bring within `window`, each released at its start and then as often as it may.
double demand_s(const std::vector<BusMessage>& messages, std::size_t count, double window_s) {
  double sum = 0.0;
  for (std::size_t k = 0; k < count; ++k)
    sum += std::ceil(window_s / messages[k].period_s - kRounding) * messages[k].wire_s;
  return sum;
}

/// Grows `begin` to the fixed point of next(); the load of what is summed is below 1, so there is one.
template <typename Next>
double fixed_point(double begin, Next&& next) {
  double now = begin;
  while (true) {
    const double then = next(now);
    if (then <= now + kRounding * 1e-3) return then;
    now = then;
  }
}

BusBudget budget_of(int bus, const Talkers& talkers, const Wire& wire) {
  BusBudget out;
  out.bus = bus;
  out.node_count = static_cast<int>(talkers.size());
  out.messages = messages_of(talkers, wire);
  for (const BusMessage& message : out.messages) {
    out.load += message.wire_s / message.period_s;
    if (message.is_cyclic) out.cycle_s += message.wire_s;
  }
  return out;
}

Talkers talkers_on(const RobotConfig& robot, int bus) {
  Talkers out;
  for (const DriveConfig& drive : robot.drives)
    if (drive.bus == bus) out.push_back({drive.node, drive.family == DriveFamily::kDamiao ? &drive.mit : nullptr});
  if (robot.hand.bus == bus) out.push_back({robot.hand.node});
  return out;
}

Talkers all_talkers(const RobotConfig& robot) {
  Talkers out;
  for (int bus = 0; bus < robot.bus_count(); ++bus)
    for (const Talker& talker : talkers_on(robot, bus)) out.push_back(talker);
  return out;
}

/// Loads alone: the latest responses are worth their time only for people.
std::vector<BusBudget> loads_of(const RobotConfig& robot, double period_s) {
  std::vector<BusBudget> out;
  for (int bus = 0; bus < robot.bus_count(); ++bus)
    out.push_back(budget_of(bus, talkers_on(robot, bus), {bus_rates(robot), period_s}));
  return out;
}

std::string rate_text(double period_s) {
  char text[64];
  std::snprintf(text, sizeof text, "%.4g Hz (period_s %.4g)", 1.0 / period_s, period_s);
  return text;
}

}  // namespace

std::optional<double> latest_response_s(const std::vector<BusMessage>& messages, std::size_t m, double bit_s) {
  double load = 0.0;
  for (std::size_t k = 0; k <= m; ++k) load += messages[k].wire_s / messages[k].period_s;
  if (load > 1.0 - 1e-6) return std::nullopt;
  const BusMessage& message = messages[m];
  const double blocking = blocking_s(messages, m);
  const double busy_s = fixed_point(message.wire_s, [&](double t) { return blocking + demand_s(messages, m + 1, t); });
  const auto instances = static_cast<int>(std::ceil(busy_s / message.period_s - kRounding));
  double latest = 0.0;
  for (int q = 0; q < std::max(instances, 1); ++q) {
    const double before = blocking + q * message.wire_s;
    // A message that comes within the first bit of ours still wins the arbitration.
    const double waits = fixed_point(before, [&](double w) { return before + demand_s(messages, m, w + bit_s); });
    latest = std::max(latest, waits - q * message.period_s + message.wire_s);
  }
  return latest;
}

std::vector<BusBudget> bus_budgets(const RobotConfig& robot, double period_s) {
  std::vector<BusBudget> out = loads_of(robot, period_s);
  const double bit_s = 1.0 / robot.controller.bus_bitrate_bit_s;
  for (BusBudget& budget : out)
    for (std::size_t m = 0; m < budget.messages.size(); ++m)
      budget.messages[m].latest_s = latest_response_s(budget.messages, m, bit_s);
  return out;
}

std::vector<BusBudget> bus_budgets(const RobotConfig& robot) { return bus_budgets(robot, robot.controller.period_s); }

double highest_load(const std::vector<BusBudget>& budgets) noexcept {
  double highest = 0.0;
  for (const BusBudget& budget : budgets) highest = std::max(highest, budget.load);
  return highest;
}

std::optional<double> shortest_period_s(const RobotConfig& robot) {
  for (int tenths = 10; kPeriodStep_s * tenths <= kLongestPeriod_s + kRounding; ++tenths) {
    const double period_s = tenths / 10000.0;
    if (broken_period_rule(period_s) != nullptr) continue;
    if (highest_load(loads_of(robot, period_s)) <= robot.controller.bus_load_limit) return period_s;
  }
  return std::nullopt;
}

std::optional<int> buses_needed(const RobotConfig& robot, double period_s) {
  const Talkers all = all_talkers(robot);
  for (std::size_t buses = 1; buses <= all.size(); ++buses) {
    // Each takes every so-manieth: of every family its share.
    double fullest = 0.0;
    for (std::size_t first = 0; first < buses; ++first) {
      Talkers share;
      for (std::size_t i = first; i < all.size(); i += buses) share.push_back(all[i]);
      fullest = std::max(fullest, budget_of(0, share, {bus_rates(robot), period_s}).load);
    }
    if (fullest <= robot.controller.bus_load_limit) return static_cast<int>(buses);
  }
  return std::nullopt;
}

std::string broken_load_rule(const RobotConfig& robot) {
  const double period_s = robot.controller.period_s, limit = robot.controller.bus_load_limit;
  const std::vector<BusBudget> budgets = loads_of(robot, period_s);
  const auto fullest = std::ranges::max_element(budgets, {}, &BusBudget::load);
  if (fullest->load <= limit) return "";
  char text[200];
  std::snprintf(text, sizeof text, "bus %d with %d nodes would be loaded to %.1f %%, above %.4g %% (controller.bus_load_limit)",
                fullest->bus, fullest->node_count, 100 * fullest->load, 100 * limit);
  const auto shortest = shortest_period_s(robot);
  const auto buses = buses_needed(robot, period_s);
  return text + std::string("; ") + (shortest ? "the highest rate that fits is " + rate_text(*shortest) : "no rate fits") +
         (buses && *buses > robot.bus_count() ? "; this rate needs " + std::to_string(*buses) + " buses" : "");
}

}  // namespace armsight
