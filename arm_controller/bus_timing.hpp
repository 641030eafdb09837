// What the time stamps of the frames tell: how regular SYNC is on each bus, how long each node takes to answer it, and each
// DAMIAO motor its command.
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
  using RowOfId = std::array<std::int8_t, kNodeIds>;

  void note_answer(const std::optional<Time>& asked, std::int8_t row, Time answered) noexcept;

  RowOfId row_of_node_, row_of_motor_, row_of_reply_;  ///< of LoopStatistics::tpdo1; -1: not ours
  std::array<std::optional<Time>, kMaxBuses> syncs_;   ///< the newest echo on each bus
  std::array<std::optional<Time>, DriveMaster::kMaxNodes> commands_;  ///< the newest echo of each motor's
};

}  // namespace armsight::arm
