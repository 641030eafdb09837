#include "host/host_io.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <utility>

#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr Duration kPeriod = std::chrono::milliseconds(4);     // the host's cycle at real pace
constexpr Duration kConnectTimeout = std::chrono::seconds(5);
constexpr Duration kAnswerTimeout = std::chrono::seconds(1);
constexpr Duration kStopTimeout = std::chrono::seconds(5);     // the lost lease's stop, within the joints' limits
constexpr Duration kSilence = std::chrono::seconds(1);         // it tells its state every 20 ms
constexpr Duration kLongestStep = std::chrono::milliseconds(20);
constexpr Duration kAlignTimeout = std::chrono::seconds(20);
constexpr Duration kAlignBound = std::chrono::milliseconds(2);
constexpr Duration kHoldTimeout = std::chrono::seconds(30);    // enabling six drives takes some seconds

volatile std::sig_atomic_t g_is_interrupted = 0;
extern "C" void on_interrupt(int) { g_is_interrupted = 1; }

std::unique_ptr<net::Clock> make_clock(const HostIoOptions& options) try {
  if (options.sim_clock.empty()) return net::make_monotonic_clock(kPeriod);
  return net::join_sim_clock(options.sim_clock, "host", 2, kPeriod);
} catch (const ConfigError&) {
  throw;
} catch (const std::runtime_error& error) {
  throw PeerLost(error.what());
}

std::unique_ptr<net::FramedStream> connect_arm(const std::string& address, net::Clock& clock) try {
  net::StreamOptions options;
  std::unique_ptr<net::FramedStream> stream = net::connect_tcp(address, options, clock, kConnectTimeout);
  stream->set_channel({net::ChannelKind::kLink, clock.arm_controller()});
  return stream;
} catch (const ConfigError&) {
  throw;
} catch (const std::runtime_error& error) {
  throw PeerLost(std::string("arm controller: ") + error.what());
}

}  // namespace

HostIo::HostIo(const HostIoOptions& options, const RobotConfig& robot)
    : robot_(robot), options_(options), clock_(make_clock(options)) {
  if (!options.camera_source.empty()) camera_ = make_camera(options.camera_source, options.intrinsics_file, *clock_);
  connect();
}

void HostIo::connect() {
  // Of an observer no hash is asked, and it may know no robot.
  const std::uint64_t hash = options_.role == wire::ROLE_COMMAND ? model_hash(robot_) : 0;
  arm_ = std::make_unique<ArmLink>(connect_arm(options_.arm_address, *clock_), *clock_,
                                   ArmLinkOptions{"host " ARMSIGHT_VERSION, hash, options_.role});
}

void HostIo::reconnect() {
  connect();
  has_had_lease_ = false;
  heard_ = 0;
  silence_ = Duration::zero();
  last_step_ = now();
}

HostIo::~HostIo() {
  try {
    arm_->say_bye();
  } catch (const PeerLost&) {  // gone already: there is nobody to say it to
  }
}

Time HostIo::step() {
  const Time now = clock_->wait_next_cycle();
  arm_->receive();
  watch_silence(now);
  frame_.reset();
  if (camera_) frame_ = camera_->poll();
  arm_->heartbeat();
  if (g_is_interrupted != 0) {
    if (options_.role == wire::ROLE_COMMAND) {
      wire::Envelope stop;
      stop.mutable_stop()->set_reason("the operator interrupted the host");
      arm_->send(std::move(stop));
    }
    throw Interrupted(options_.role == wire::ROLE_COMMAND);
  }
  return now;
}

void HostIo::idle(Duration duration) {
  const Time end = now() + duration;
  while (clock_->wait_next_cycle() < end)
    if (g_is_interrupted != 0) throw Interrupted(false);
}

// A step that took long was this program's own absence, not the controller's: it counts as one cycle or so.
void HostIo::watch_silence(Time now) {
  const bool is_heard = arm_->last_received() != heard_;
  silence_ = is_heard ? Duration::zero() : silence_ + std::min(now - last_step_, kLongestStep);
  heard_ = arm_->last_received();
  last_step_ = now;
  if (arm_->hello() && silence_ > kSilence)
    throw PeerLost("arm controller: silent for 1 s, though the connection is open");
}

bool HostIo::wait_until(const std::function<bool()>& claim, Duration timeout) {
  const Time end = now() + timeout;
  while (!claim()) {
    if (now() >= end) return false;
    step();
  }
  return true;
}

CommandOutcome HostIo::command(wire::Envelope message) {
  const CommandOutcome outcome = ask(message);
  if (outcome.is_accepted || outcome.reason != wire::REFUSAL_REASON_NO_LEASE || !has_had_lease_) return outcome;
  wire::Envelope lease;
  lease.mutable_lease_request();
  const CommandOutcome lease_outcome = ask(std::move(lease));
  if (!lease_outcome.is_accepted) return lease_outcome;
  std::fprintf(stderr,
               "host: this machine held the host up until its lease ran out; the arm held, the lease is taken again\n");
  wait_until([&] { return arm_->state() && arm_->state()->mode() != wire::MODE_STOPPING; }, kStopTimeout);
  return ask(std::move(message));
}

CommandOutcome HostIo::ask(wire::Envelope message) {
  const bool is_lease = message.has_lease_request();
  const std::uint64_t sequence = arm_->send(std::move(message));
  const auto is_answered = [&] { return arm_->outcome(sequence) || arm_->hello_refusal(); };
  if (!wait_until(is_answered, kAnswerTimeout)) throw PeerLost("arm controller: no answer within 1 s");
  if (!arm_->outcome(sequence)) throw CommandFailed("arm controller: " + arm_->hello_refusal()->text);
  const CommandOutcome outcome = *arm_->outcome(sequence);
  has_had_lease_ |= is_lease && outcome.is_accepted;
  return outcome;
}

void HostIo::demand(wire::Envelope message, const std::string& what) {
  const CommandOutcome outcome = command(std::move(message));
  if (!outcome.is_accepted) throw CommandFailed(what + ": refused: " + outcome.text);
}

void catch_interrupts() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

void open_session(HostIo& io, bool needs_time) {
  ArmLink& arm = io.arm();
  const bool is_answered = io.wait_until([&] { return arm.hello() || arm.hello_refusal(); }, kConnectTimeout);
  if (!is_answered) throw PeerLost("arm controller: no answer to Hello within 5 s");
  if (arm.hello_refusal()) throw CommandFailed("arm controller: " + arm.hello_refusal()->text);
  const bool is_informed = io.wait_until([&] { return arm.state() && arm.model(); }, kAnswerTimeout);
  if (!is_informed) throw PeerLost("arm controller: tells neither its state nor its model");
  if (!needs_time) return;
  const auto is_aligned = [&] { return arm.alignment().bound() && *arm.alignment().bound() < kAlignBound; };
  if (!io.wait_until(is_aligned, kAlignTimeout)) throw CommandFailed("clocks: no agreement within 2 ms after 20 s");
}

std::string fault_text(HostIo& io) {
  const ArmLink& arm = io.arm();
  return "the arm stands in fault " + std::to_string(arm.state()->fault_code()) +
         (arm.fault() ? " (" + arm.fault()->text() + ")" : "") + "; --clear-fault clears it";
}

void take_command(HostIo& io, bool clear_fault) {
  ArmLink& arm = io.arm();
  wire::Envelope lease;
  lease.mutable_lease_request();
  io.demand(std::move(lease), "lease");
  const auto is_configured = [&] {
    const wire::Mode mode = arm.state()->mode();
    return mode == wire::MODE_READY || mode == wire::MODE_HOLD || mode == wire::MODE_SERVO ||
           mode == wire::MODE_STOPPING || mode == wire::MODE_FAULT;
  };
  if (!io.wait_until(is_configured, kHoldTimeout)) {
    throw CommandFailed(std::string("power on: the arm is in ") + to_text(arm.state()->mode()) + " after 30 s");
  }
  if (arm.state()->mode() == wire::MODE_FAULT && !clear_fault) {
    throw CommandFailed(fault_text(io));
  }
  wire::Envelope hold;
  hold.mutable_mode_request()->set_mode(wire::MODE_HOLD);
  hold.mutable_mode_request()->set_clear_fault(clear_fault);
  io.demand(std::move(hold), "power on");
  const auto is_holding = [&] { return arm.state()->mode() == wire::MODE_HOLD && arm.state()->is_still(); };
  if (!io.wait_until(is_holding, kHoldTimeout)) {
    throw CommandFailed(std::string("power on: the arm is in ") + to_text(arm.state()->mode()) + " after 30 s");
  }
}

}  // namespace armsight::host
