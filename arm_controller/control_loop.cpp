#include "arm_controller/control_loop.hpp"

#include <time.h>

namespace armsight::arm {
namespace {

// Thread time, not wall time: what the tick costs, whatever else the machine does.
double thread_time_us() noexcept {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

}  // namespace

ControlLoop::ControlLoop(const RobotConfig& robot, const StartModel& start, CanBus& bus, Mailboxes& mailboxes,
                         Tape& tape, LoopStatistics& statistics)
    : bus_(bus), mailboxes_(mailboxes), tape_(tape), statistics_(statistics), master_(robot),
      controller_(robot, start) {}

void ControlLoop::cycle(Time now, std::uint64_t missed) noexcept {
  record_.frame_count = record_.frames_left_out = 0;
  const JointSamples& joints =
      master_.receive(bus_, now, [this](const BusFrame& frame) { keep(frame, false); });
  collect_inbox(missed);
  const double begin_us = thread_time_us();
  const TickOutput& output = controller_.tick(now, joints, inbox_);
  record_.tick_us = thread_time_us() - begin_us;
  last_command_ = output.command;
  master_.send(bus_, output.command, now, [this](const BusFrame& frame) { keep(frame, true); });

  statistics_.tick.add(record_.tick_us);
  record_.cycle = statistics_.cycles.fetch_add(1, std::memory_order_relaxed) + 1;
  record_.missed = missed;
  record_.cycle_time = now;
  statistics_.missed.store(missed, std::memory_order_relaxed);
  statistics_.bus_send_failures.store(master_.error_totals().send_failures, std::memory_order_relaxed);
  publish(output);
}

void ControlLoop::leave(Time now) noexcept {
  last_command_.power = last_command_.power == PowerRequest::kOff ? PowerRequest::kOff : PowerRequest::kQuickStop;
  for (int i = 0; i < 2; ++i) {  // the command takes effect in the master's next look at the nodes
    master_.receive(bus_, now, [](const BusFrame&) {});
    master_.send(bus_, last_command_, now, [](const BusFrame&) {});
  }
}

void ControlLoop::collect_inbox(std::uint64_t missed) noexcept {
  inbox_.is_late = missed > record_.missed;
  inbox_.stop = mailboxes_.stop.take();
  inbox_.model_not_saved = mailboxes_.model_not_saved.take();
  inbox_.lease = mailboxes_.lease.take();
  inbox_.mode = mailboxes_.mode.take();
  inbox_.goal = mailboxes_.goal.take();
  inbox_.hand = mailboxes_.hand.take();
  inbox_.recalibration = mailboxes_.recalibration.take();
  inbox_.proposal = mailboxes_.proposal.take();
  inbox_.look_count = 0;
  while (inbox_.look_count < kMaxLooks && mailboxes_.looks.pop(inbox_.looks[inbox_.look_count])) ++inbox_.look_count;
}

void ControlLoop::publish(const TickOutput& output) noexcept {
  for (std::size_t i = 0; i < output.event_count; ++i) {
    mailboxes_.events.push(output.events[i]);
    tape_.events.push(output.events[i]);
  }
  mailboxes_.state.put(output.snapshot);
  record_.state = output.snapshot;
  if (!tape_.ticks.push(record_)) statistics_.tape_overflows.fetch_add(1, std::memory_order_relaxed);
}

void ControlLoop::keep(const BusFrame& frame, bool is_sent) noexcept {
  if (record_.frame_count < TickRecord::kMaxFrames) {
    record_.frames[record_.frame_count++] = {frame, is_sent};
  } else {
    ++record_.frames_left_out;
  }
}

}  // namespace armsight::arm
