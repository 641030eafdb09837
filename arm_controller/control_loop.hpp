// The cycle: receive → tick → send. Everything it touches was allocated before; it waits for nobody.
#pragma once

#include "arm_controller/bus_timing.hpp"
#include "arm_controller/can_bus.hpp"
#include "arm_controller/loop_state.hpp"
#include "arm_controller/statistics.hpp"
#include "arm_controller/tick_tape.hpp"

namespace armsight::arm {

class ControlLoop {
 public:
  ControlLoop(const RobotConfig& robot, const StartModel& start, CanBus& bus, Mailboxes& mailboxes, Tape& tape,
              LoopStatistics& statistics);

  /// One cycle at `now`; missed: cycles skipped so far, of the clock.
  void cycle(Time now, std::uint64_t missed) noexcept;
  /// The same, given what the mailboxes gave when it was recorded.
  void repeat_cycle(Time now, std::uint64_t missed, const TickInbox& inbox) noexcept;
  /// Goes on from a checkpoint of this very executable; precondition: its size.
  void restore(std::span<const std::byte> checkpoint) noexcept;
  /// Last words to the drives: quick stop and hold by their own supervision.
  void leave(Time now) noexcept;

  Mode mode() const noexcept { return state_.controller.mode(); }
  bool bus_is_lost() const noexcept { return state_.master.error_totals().lost; }
  const DriveMaster& master() const noexcept { return state_.master; }

 private:
  void collect_inbox() noexcept;
  void publish(const TickOutput& output) noexcept;
  void step(Time now, std::uint64_t missed) noexcept;
  void keep(const TapeFrame& frame) noexcept;
  void keep_inputs() noexcept;

  CanBus& bus_;
  Mailboxes& mailboxes_;
  Tape& tape_;
  LoopStatistics& statistics_;
  BusTiming timing_;
  LoopState state_;
  TickInbox inbox_;
  TickRecord record_;
  JointCommand last_command_;
};

}  // namespace armsight::arm
