// The cycle: receive → tick → send. Everything it touches was allocated before; it waits for nobody.
#pragma once

#include "arm_controller/can_bus.hpp"
#include "arm_controller/canopen_master.hpp"
#include "arm_controller/controller.hpp"
#include "arm_controller/statistics.hpp"
#include "arm_controller/tick_tape.hpp"

namespace armsight::arm {

class ControlLoop {
 public:
  ControlLoop(const RobotConfig& robot, const StartModel& start, CanBus& bus, Mailboxes& mailboxes, Tape& tape,
              LoopStatistics& statistics);

  /// One cycle at `now`; missed: cycles skipped so far, of the clock.
  void cycle(Time now, std::uint64_t missed) noexcept;
  /// Last words to the drives: quick stop and hold by their own supervision.
  void leave(Time now) noexcept;

  Mode mode() const noexcept { return controller_.mode(); }
  bool bus_is_lost() const noexcept { return master_.error_totals().lost; }
  const CanopenMaster& master() const noexcept { return master_; }

 private:
  void collect_inbox(std::uint64_t missed) noexcept;
  void publish(const TickOutput& output) noexcept;
  void keep(const BusFrame& frame, bool is_sent) noexcept;

  CanBus& bus_;
  Mailboxes& mailboxes_;
  Tape& tape_;
  LoopStatistics& statistics_;
  CanopenMaster master_;
  Controller controller_;
  TickInbox inbox_;
  TickRecord record_;
  JointCommand last_command_;
};

}  // namespace armsight::arm
