// All that a cycle remembers to the next one, in one value that owns nothing outside itself: its bytes are a checkpoint
// from which the same executable goes on exactly as before (black_box_replay).
#pragma once

#include <type_traits>

#include "arm_controller/drive_master.hpp"
#include "arm_controller/controller.hpp"

namespace armsight::arm {

struct LoopState {
  LoopState(const RobotConfig& robot, const StartModel& start)
      : master(robot, start.last_seen_rad), controller(robot, start) {}

  DriveMaster master;
  Controller controller;
  std::uint64_t cycle = 0;   ///< done so far
  std::uint64_t missed = 0;  ///< told by the clock so far
};
// What need not be destroyed holds no memory of its own; what has no virtual function holds no address of code.
static_assert(std::is_trivially_destructible_v<LoopState> && !std::is_polymorphic_v<LoopState>);
static_assert(std::is_trivially_destructible_v<TickInbox> && !std::is_polymorphic_v<TickInbox>);

}  // namespace armsight::arm
