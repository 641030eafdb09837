#include "arm_controller/bus_timing.hpp"

namespace armsight::arm {

BusTiming::BusTiming(const RobotConfig& robot, LoopStatistics& statistics)
    : statistics_(statistics), period_(seconds_to_duration(robot.controller.period_s)) {
  row_of_node_.fill(-1);
  std::int8_t row = 0;
  for (int i = 0; i < robot.arm.joint_count(); ++i)
    row_of_node_[robot.drives[static_cast<std::size_t>(i)].node % kNodeIds] = row++;
  row_of_node_[robot.hand.node % kNodeIds] = row;
}

void BusTiming::note(const BusFrame& frame) noexcept {
  if (frame.is_own_echo) {
    if (frame.frame.id != kSyncId) return;
    if (sync_) {
      const Duration off = frame.time - *sync_ - period_;
      statistics_.sync_period.add(off < Duration{} ? -off : off);
    }
    sync_ = frame.time;
    return;
  }
  if (!sync_ || frame.frame.id <= kTpdo1Base || frame.frame.id >= kTpdo1Base + kNodeIds) return;
  const std::int8_t row = row_of_node_[frame.frame.id - kTpdo1Base];
  if (row >= 0) statistics_.tpdo1[static_cast<std::size_t>(row)].add(frame.time - *sync_);
}

}  // namespace armsight::arm
