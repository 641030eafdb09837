// Does the arm's traffic fit on its CAN buses at a given rate? From the robot file alone: every message that may be on
// each bus, its longest time on the wire, how often; from these the load, and the latest response of each message under
// fixed priorities without preemption (Davis, Burns, Bril, Lukkien 2007). Each drive sends what waits by priority; what
// the controller queues for a cycle is in that order.
//
// Background beside the cycle (controller.md §3.2): heartbeats, 20 SDO exchanges/s and 5 EMCY/s on each bus.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/can_frames.hpp"
#include "protocol/config.hpp"

namespace armsight {

/// One message of a bus: never more often than once a period.
struct BusMessage {
  std::string name;               ///< "TPDO1 of node 3"
  std::uint32_t id = 0;           ///< its priority: the lower the earlier
  int bits = 0;                   ///< worst case with stuffing
  double wire_s = 0.0;            ///< the same in time
  double period_s = 0.0;
  bool is_cyclic = false;         ///< once a cycle, due before the next one begins
  std::optional<double> latest_s; ///< from its release to its last bit; nullopt: without bound, the bus is overloaded
};

struct BusBudget {
  int bus = 0;
  int node_count = 0;
  std::vector<BusMessage> messages;  ///< in order of priority
  double load = 0.0;                 ///< 0 … 1 and beyond
  double cycle_s = 0.0;              ///< all cyclic messages, one after the other
};

/// One for each bus that a drive of the robot is on, at the configured period.
std::vector<BusBudget> bus_budgets(const RobotConfig& robot);
/// The same with the period changed.
std::vector<BusBudget> bus_budgets(const RobotConfig& robot, double period_s);

/// Of messages in order of priority, from release to last bit, in whatever unit wire, period and bit are; nullopt: the
/// messages up to this one are more than the bus carries.
std::optional<double> latest_response_s(const std::vector<BusMessage>& messages, std::size_t m, double bit_s);

/// Load of the fullest bus.
double highest_load(const std::vector<BusBudget>& budgets) noexcept;

/// The shortest period inside controller.bus_load_limit of those that 0x60C2 can express; nullopt: none up to 0.1 s.
std::optional<double> shortest_period_s(const RobotConfig& robot);
/// How many buses like these carry the nodes at that period if each takes its share; nullopt: not one node fits.
std::optional<int> buses_needed(const RobotConfig& robot, double period_s);

/// One sentence if the worst case at the configured period is above the limit, naming the rate that fits; else "".
std::string broken_load_rule(const RobotConfig& robot);

}  // namespace armsight
