#include "protocol/bus_budget.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace armsight {

namespace {

constexpr double kHeartbeat_s = 0.1;      // 0x1017 and our own
constexpr double kSdoExchange_s = 0.05;   // 20 a second
constexpr double kEmergency_s = 0.2;      // 5 a second
constexpr int kWholePdo = 8, kHeartbeatSize = 1, kSyncSize = 1;
constexpr double kLongestPeriod_s = 0.1, kShortestPeriod_s = 0.001;
constexpr double kPeriodStep_s = 0.0001;  // the finer unit of 0x60C2
constexpr double kRounding = 1e-9;

struct Wire {
  double bitrate_bit_s;
  double period_s;
};

class Messages {
 public:
  explicit Messages(const Wire& wire) : wire_(wire) {}

  void cyclic(const std::string& name, std::uint32_t id, int size) { add(name, id, size, wire_.period_s, true); }
  void sporadic(const std::string& name, std::uint32_t id, int size, double period_s) {
    add(name, id, size, period_s, false);
  }
  std::vector<BusMessage> in_order() {
    std::ranges::stable_sort(all_, {}, &BusMessage::id);
    return std::move(all_);
  }

 private:
  void add(const std::string& name, std::uint32_t id, int size, double period_s, bool is_cyclic) {
    const int bits = worst_case_bits(size);
    all_.push_back({name, id, bits, bits / wire_.bitrate_bit_s, period_s, is_cyclic, std::nullopt});
  }
  Wire wire_;
  std::vector<BusMessage> all_;
};

std::vector<BusMessage> messages_of(const std::vector<std::uint8_t>& nodes, const Wire& wire) {
  Messages out(wire);
  out.cyclic("SYNC", kSyncId, kSyncSize);
  // One of all nodes may be in trouble or be asked at a time: the allowance is the bus', whoever uses it.
  out.sporadic("EMCY, any node", kEmcyBase + nodes.front(), 8, kEmergency_s);
  out.sporadic("SDO answer, any node", kSdoAnswerBase + nodes.front(), 8, kSdoExchange_s);
  out.sporadic("SDO request, any node", kSdoRequestBase + nodes.front(), 8, kSdoExchange_s);
  for (const std::uint8_t node : nodes) {
    const std::string of = " of node " + std::to_string(node);
    out.cyclic("TPDO1" + of, kTpdo1Base + node, kWholePdo);
    out.cyclic("RPDO1" + of, kRpdo1Base + node, kWholePdo);
    out.sporadic("heartbeat" + of, kHeartbeatBase + node, kHeartbeatSize, kHeartbeat_s);
  }
  out.sporadic("heartbeat of the controller", kHeartbeatBase + kControllerNode, kHeartbeatSize, kHeartbeat_s);
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

BusBudget budget_of(int bus, const std::vector<std::uint8_t>& nodes, const Wire& wire) {
  BusBudget out;
  out.bus = bus;
  out.node_count = static_cast<int>(nodes.size());
  out.messages = messages_of(nodes, wire);
  for (const BusMessage& message : out.messages) {
    out.load += message.wire_s / message.period_s;
    if (message.is_cyclic) out.cycle_s += message.wire_s;
  }
  return out;
}

std::vector<std::uint8_t> nodes_on(const RobotConfig& robot, int bus) {
  std::vector<std::uint8_t> nodes;
  for (const DriveConfig& drive : robot.drives)
    if (drive.bus == bus) nodes.push_back(drive.node);
  if (robot.hand.bus == bus) nodes.push_back(robot.hand.node);
  return nodes;
}

std::vector<std::uint8_t> all_nodes(const RobotConfig& robot) {
  std::vector<std::uint8_t> nodes;
  for (int bus = 0; bus < robot.bus_count(); ++bus)
    for (const std::uint8_t node : nodes_on(robot, bus)) nodes.push_back(node);
  return nodes;
}

/// Loads alone: the latest responses are worth their time only for people.
std::vector<BusBudget> loads_of(const RobotConfig& robot, double period_s) {
  std::vector<BusBudget> out;
  for (int bus = 0; bus < robot.bus_count(); ++bus)
    out.push_back(budget_of(bus, nodes_on(robot, bus), {robot.controller.bus_bitrate_bit_s, period_s}));
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

int stuffed_bits(const CanFrame& frame) noexcept {
  constexpr int kHead = 19, kCrcBits = 15, kTail = 13;  // tail: both delimiters, acknowledge, end, space; unstuffed
  std::array<bool, kHead + 64 + kCrcBits> bits{};
  int count = 0;
  std::uint16_t crc = 0;
  const auto put = [&](bool bit) { bits[static_cast<std::size_t>(count++)] = bit; };
  const auto put_all = [&](std::uint32_t value, int width) {
    for (int i = width - 1; i >= 0; --i) put((value >> i & 1) != 0);
  };
  put_all(0, 1);              // start of frame
  put_all(frame.id, 11);
  put_all(0, 3);              // data frame, 11-bit identifier, reserved
  put_all(frame.size, 4);
  for (int i = 0; i < frame.size; ++i) put_all(frame.data[static_cast<std::size_t>(i)], 8);
  for (int i = 0; i < count; ++i) {
    const bool differs = bits[static_cast<std::size_t>(i)] != ((crc >> 14 & 1) != 0);
    crc = static_cast<std::uint16_t>(crc << 1 & 0x7FFF);
    if (differs) crc ^= 0x4599;
  }
  put_all(crc, kCrcBits);
  int stuffed = 0, run = 0;
  bool last = true;           // the bus was idle
  for (int i = 0; i < count; ++i) {
    const bool bit = bits[static_cast<std::size_t>(i)];
    run = bit == last && i > 0 ? run + 1 : 1;
    last = bit;
    if (run < 5) continue;
    ++stuffed;                // the opposite bit follows and begins the next run
    last = !bit;
    run = 1;
  }
  return count + stuffed + kTail;
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
  const std::vector<std::uint8_t> nodes = all_nodes(robot);
  for (std::size_t buses = 1; buses <= nodes.size(); ++buses) {
    const std::size_t most = (nodes.size() + buses - 1) / buses;  // on the fullest
    const std::vector<std::uint8_t> share(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(most));
    const BusBudget fullest = budget_of(0, share, {robot.controller.bus_bitrate_bit_s, period_s});
    if (fullest.load <= robot.controller.bus_load_limit) return static_cast<int>(buses);
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
