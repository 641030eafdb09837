// What the time stamps of the frames tell: how regular SYNC is on the bus, and how long each node takes to answer it.
#pragma once

#include <array>
#include <optional>

#include "arm_controller/can_bus.hpp"
#include "arm_controller/statistics.hpp"

namespace armsight::arm {

class BusTiming {
 public:
  BusTiming(const RobotConfig& robot, LoopStatistics& statistics);

  /// Every frame as it was received. An answer counts from the newest SYNC; one that is a whole period late shows as a
  /// missed sample elsewhere (fault 104), not here.
  void note(const BusFrame& frame) noexcept;

 private:
  static constexpr std::size_t kNodeIds = 128;

  LoopStatistics& statistics_;
  Duration period_;
  std::array<std::int8_t, kNodeIds> row_of_node_;  ///< of LoopStatistics::tpdo1; -1: not ours
  std::optional<Time> sync_;                       ///< the newest echo
};

}  // namespace armsight::arm
