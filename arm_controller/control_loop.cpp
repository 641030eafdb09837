#include "arm_controller/control_loop.hpp"

#include <cstring>

#include "protocol/transport/wait.hpp"

namespace armsight::arm {

ControlLoop::ControlLoop(const RobotConfig& robot, const StartModel& start, CanBus& bus, Mailboxes& mailboxes,
                         Tape& tape, LoopStatistics& statistics)
    : bus_(bus), mailboxes_(mailboxes), tape_(tape), statistics_(statistics), timing_(robot, statistics),
      state_(robot, start) {
  tape_.checkpoints.reserve(sizeof state_);
}

void ControlLoop::cycle(Time now, std::uint64_t missed) noexcept {
  if (state_.cycle % kCheckpointEvery == 0) tape_.checkpoints.put(state_.cycle, std::as_bytes(std::span(&state_, 1)));
  collect_inbox();
  step(now, missed);
}

void ControlLoop::repeat_cycle(Time now, std::uint64_t missed, const TickInbox& inbox) noexcept {
  inbox_ = inbox;
  step(now, missed);
}

// The bytes were a LoopState of this executable, which owns nothing outside itself (loop_state.hpp).
void ControlLoop::restore(std::span<const std::byte> checkpoint) noexcept {
  std::memcpy(static_cast<void*>(&state_), checkpoint.data(), sizeof state_);
}

void ControlLoop::step(Time now, std::uint64_t missed) noexcept {
  record_.frame_count = record_.frames_left_out = 0;
  inbox_.is_late = missed > state_.missed;
  state_.missed = record_.missed = missed;
  record_.cycle = ++state_.cycle;
  record_.cycle_time = now;
  const JointSamples& joints = state_.master.receive(bus_, now, [this](const BusFrame& frame) {
    timing_.note(frame);
    keep({frame, false, SendResult::kSent});
  });
  // The machine's clock: it is read without a system call, which a thread's own processor time is not.
  const std::int64_t begin_ns = net::monotonic_ns();
  const TickOutput& output = state_.controller.tick(now, joints, inbox_);
  const Duration tick{net::monotonic_ns() - begin_ns};
  record_.tick_us = 1e-3 * static_cast<double>(tick.count());
  last_command_ = output.command;
  state_.master.send(bus_, output.command, now,
                     [this](const BusFrame& frame, SendResult result) { keep({frame, true, result}); });
  keep_inputs();
  statistics_.tick.add(tick);
  statistics_.cycles.store(state_.cycle, std::memory_order_relaxed);
  statistics_.missed.store(missed, std::memory_order_relaxed);
  statistics_.bus_send_failures.store(state_.master.error_totals().send_failures, std::memory_order_relaxed);
  publish(output);
}

void ControlLoop::leave(Time now) noexcept {
  last_command_.power = last_command_.power == PowerRequest::kOff ? PowerRequest::kOff : PowerRequest::kQuickStop;
  for (int i = 0; i < 2; ++i) {  // the command takes effect in the master's next look at the nodes
    state_.master.receive(bus_, now, [](const BusFrame&) {});
    state_.master.send(bus_, last_command_, now, [](const BusFrame&, SendResult) {});
  }
}

void ControlLoop::collect_inbox() noexcept {
  inbox_.stop = mailboxes_.stop.take();
  inbox_.model_not_saved = mailboxes_.model_not_saved.take();
  inbox_.lease = mailboxes_.lease.take();
  inbox_.mode = mailboxes_.mode.take();
  inbox_.goal = mailboxes_.goal.take();
  inbox_.hand = mailboxes_.hand.take();
  inbox_.stiffness = mailboxes_.stiffness.take();
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
  if (const auto check = state_.master.take_self_check()) mailboxes_.self_check.put(*check);
  mailboxes_.state.put(output.snapshot);
  record_.state = output.snapshot;
  if (!tape_.ticks.push(record_)) statistics_.tape_overflows.fetch_add(1, std::memory_order_relaxed);
}

void ControlLoop::keep(const TapeFrame& frame) noexcept {
  if (record_.frame_count < TickRecord::kMaxFrames) {
    record_.frames[record_.frame_count++] = frame;
  } else {
    ++record_.frames_left_out;
  }
}

void ControlLoop::keep_inputs() noexcept {
  record_.errors = state_.master.errors_of_cycle();
  record_.stop = inbox_.stop;
  record_.model_not_saved = inbox_.model_not_saved;
  record_.lease = inbox_.lease;
  const bool has_orders = inbox_.mode || inbox_.goal || inbox_.hand || inbox_.stiffness || inbox_.recalibration ||
                          inbox_.proposal || inbox_.look_count > 0;
  record_.has_orders = has_orders;
  if (has_orders) tape_.orders.push({record_.cycle, inbox_});
}

}  // namespace armsight::arm
