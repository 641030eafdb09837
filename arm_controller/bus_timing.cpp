#include "arm_controller/bus_timing.hpp"

namespace armsight::arm {

BusTiming::BusTiming(const RobotConfig& robot, LoopStatistics& statistics)
    : statistics_(statistics), period_(seconds_to_duration(robot.controller.period_s)) {
  for (RowOfId* rows : {&row_of_node_, &row_of_motor_, &row_of_reply_}) rows->fill(-1);
  std::int8_t row = 0;
  for (int i = 0; i < robot.arm.joint_count(); ++i, ++row) {
    const DriveConfig& drive = robot.drives[static_cast<std::size_t>(i)];
    const bool is_motor = drive.family == DriveFamily::kDamiao;
    (is_motor ? row_of_motor_ : row_of_node_)[drive.node % kNodeIds] = row;
    if (is_motor) row_of_reply_[drive.mit.reply_id % kNodeIds] = row;
  }
  row_of_node_[robot.hand.node % kNodeIds] = row;
}

void BusTiming::note_answer(const std::optional<Time>& asked, std::int8_t row, Time answered) noexcept {
  if (asked && row >= 0) statistics_.tpdo1[static_cast<std::size_t>(row)].add(answered - *asked);
}

void BusTiming::note(const BusFrame& frame) noexcept {
  if (frame.bus >= kMaxBuses) return;
  std::optional<Time>& sync = syncs_[frame.bus];
  const std::uint32_t id = frame.frame.id;
  if (frame.is_own_echo && id == kSyncId) {
    if (sync) {
      const Duration off = frame.time - *sync - period_;
      statistics_.sync_period.add(off < Duration{} ? -off : off);
    }
    sync = frame.time;
  } else if (frame.is_own_echo) {
    const std::int8_t row = id < kNodeIds ? row_of_motor_[id] : std::int8_t{-1};
    if (row >= 0) commands_[static_cast<std::size_t>(row)] = frame.time;
  } else if (id > kTpdo1Base && id < kTpdo1Base + kNodeIds) {
    note_answer(sync, row_of_node_[id - kTpdo1Base], frame.time);
  } else if (id < kNodeIds) {
    const std::int8_t row = row_of_reply_[id];
    if (row >= 0) note_answer(commands_[static_cast<std::size_t>(row)], row, frame.time);
  }
}

}  // namespace armsight::arm
