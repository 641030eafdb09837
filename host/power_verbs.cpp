#include "host/power_verbs.hpp"

#include <ostream>

#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr Duration kPowerTimeout = std::chrono::seconds(30);  // a node that must be configured again takes seconds

wire::Envelope mode_request(wire::Mode mode, bool clear_fault) {
  wire::Envelope message;
  message.mutable_mode_request()->set_mode(mode);
  message.mutable_mode_request()->set_clear_fault(clear_fault);
  return message;
}

void take_lease(HostIo& io) {
  wire::Envelope lease;
  lease.mutable_lease_request();
  io.demand(std::move(lease), "lease");
}

wire::Mode mode_of(HostIo& io) { return io.arm().state()->mode(); }

}  // namespace

void run_enable(HostIo& io, bool clear_fault, std::ostream& out) {
  take_command(io, clear_fault);
  out << "enabled: " << to_text(mode_of(io)) << ", still" << std::endl;
}

void run_disable(HostIo& io, std::ostream& out) {
  if (mode_of(io) == wire::MODE_FAULT) throw CommandFailed(fault_text(io));
  take_lease(io);
  io.demand(mode_request(wire::MODE_READY, false), "disable");
  if (!io.wait_until([&] { return mode_of(io) == wire::MODE_READY; }, kPowerTimeout))
    throw CommandFailed(std::string("disable: the arm is in ") + to_text(mode_of(io)) + " after 30 s");
  out << "disabled: " << to_text(mode_of(io)) << std::endl;
}

void run_clear(HostIo& io, std::ostream& out) {
  if (mode_of(io) != wire::MODE_FAULT) {
    out << "clear: no fault is latched; the arm is in " << to_text(mode_of(io)) << std::endl;
    return;
  }
  const std::uint32_t code = io.arm().state()->fault_code();
  take_lease(io);
  io.demand(mode_request(wire::MODE_READY, true), "clear");
  bool has_left = false;  // the state told may still be the one before
  const auto is_over = [&] {
    has_left |= mode_of(io) != wire::MODE_FAULT;
    return has_left && (mode_of(io) == wire::MODE_READY || mode_of(io) == wire::MODE_FAULT);
  };
  const bool is_in_time = io.wait_until(is_over, kPowerTimeout);
  if (mode_of(io) == wire::MODE_FAULT) throw CommandFailed("clear: the fault came back: " + fault_text(io));
  if (!is_in_time) throw CommandFailed(std::string("clear: the arm is in ") + to_text(mode_of(io)) + " after 30 s");
  out << "cleared: fault " << code << "; " << to_text(mode_of(io)) << std::endl;
}

}  // namespace armsight::host
