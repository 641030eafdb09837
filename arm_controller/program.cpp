#include "arm_controller/program.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "arm_controller/emulated_bus.hpp"
#include "arm_controller/last_position.hpp"
#include "arm_controller/real_time.hpp"
#include "arm_controller/several_buses.hpp"
#include "arm_controller/socket_can.hpp"
#include "arm_controller/state_folder.hpp"
#include "arm_controller/two_threads.hpp"
#include "protocol/bus_budget.hpp"

namespace armsight::arm {
namespace {

constexpr Duration kLongestStop = std::chrono::seconds(5);
constexpr Duration kShortestLinkPeriod = std::chrono::milliseconds(2);
constexpr int kRoleController = 1;
constexpr int kInternalError = 1;

RobotConfig load(const Flags& flags) {
  RobotConfig robot = load_robot(flags.config);
  double& period_s = robot.controller.period_s;
  std::ostringstream where;
  if (flags.rate_hz > 0.0) {
    period_s = 1.0 / flags.rate_hz;
    where << "--rate " << flags.rate_hz << " (" << flags.config << "): ";
    if (const char* rule = broken_period_rule(period_s)) throw FlagError(where.str() + "the period " + rule);
    if (const char* rule = broken_deadline_rule(robot.controller.rpdo_deadline_s, period_s))
      throw FlagError(where.str() + "controller.rpdo_deadline_s " + rule);
  } else {
    where << flags.config << ": controller.period_s = " << period_s << ": ";
  }
  if (const std::string rule = broken_load_rule(robot); !rule.empty()) throw FlagError(where.str() + rule);
  return robot;
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

std::unique_ptr<net::Clock> make_clock(const Flags& flags, const RobotConfig& robot) {
  const Duration period = seconds_to_duration(robot.controller.period_s);
  if (flags.sim_clock.empty()) return net::make_monotonic_clock(period);
  try {
    return net::join_sim_clock(flags.sim_clock, "arm_controller", kRoleController, period);
  } catch (const std::exception& e) {
    throw BusError(e.what());
  }
}

void check_bus_count(const Flags& flags, const RobotConfig& robot) {
  const std::size_t given = flags.can.size() + flags.emulated_bus.size(), needed = static_cast<std::size_t>(robot.bus_count());
  if (given == needed) return;
  throw FlagError(std::string(flags.can.empty() ? "--bus" : "--can") + " is given " + std::to_string(given) + " times, the drives of " +
                  flags.config + " are on " + std::to_string(needed) + (needed == 1 ? " bus" : " buses"));
}

std::unique_ptr<CanBus> make_bus(const Flags& flags, const RobotConfig& robot, net::Clock& clock) {
  std::vector<std::unique_ptr<CanBus>> buses;
  for (const std::string& interface : flags.can) {
    const bool speaks_fd = robot.has_fd_drive(static_cast<int>(buses.size()));
    buses.push_back(open_socket_can(interface, clock, CanHears::kController, speaks_fd));
  }
  try {
    for (const std::string& path : flags.emulated_bus)
      buses.push_back(join_emulated_bus(path, clock, static_cast<int>(buses.size())));
  } catch (const std::exception& e) {
    throw BusError(e.what());
  }
  return join_buses(std::move(buses));
}

/// "emulated", "socketcan can0+can1": what recordings and the link are told.
std::string kind_of_bus(const Flags& flags) {
  if (flags.can.empty()) return "emulated";
  std::string text = "socketcan ";
  for (const std::string& interface : flags.can) text += (&interface == &flags.can.front() ? "" : "+") + interface;
  return text;
}

}  // namespace

Program::Program(const Flags& flags) : requires_real_time_(flags.require_rt), cpu_(flags.cpu), robot_(load(flags)) {
  check_bus_count(flags, robot_);
  state_folder_ = hold_state_folder(flags.state);
  start_ = load_model_in_force(flags.state, robot_);
  const LastPosition last = load_last_position(flags.state, robot_);
  start_.last_seen_rad = last.q_reading_rad;
  if (!last.why.empty())
    std::fprintf(stderr, "arm_controller: %s; where the joints were last seen is not known\n", last.why.c_str());
  clock_ = make_clock(flags, robot_);
  bus_ = make_bus(flags, robot_, *clock_);
  const bool is_emulated = flags.can.empty();
  const std::string bus = kind_of_bus(flags);
  files_ = std::make_unique<FileWriter>(flags.state, robot_, bus, text_of(flags.config), tape_);
  link_ = std::make_unique<LinkServer>(flags.listen, robot_, bus, mailboxes_, statistics_, *files_, *clock_);
  files_->begin(clock_->now());  // an address that is taken must not push the last recording out
  loop_ = std::make_unique<ControlLoop>(robot_, start_, *bus_, mailboxes_, tape_, statistics_);
  std::printf("arm_controller: bus %s (%s, %g Mbit/s)\n", bus_->name().c_str(), is_emulated ? "emulated" : "SocketCAN",
              1e-6 * robot_.controller.bus_bitrate_bit_s);
  std::printf("arm_controller: listening on %s:%u\n", flags.listen.substr(0, flags.listen.rfind(':')).c_str(),
              static_cast<unsigned>(link_->port()));
}

Program::~Program() = default;

int Program::run(const std::atomic<bool>& leaves) {
  try {
    return clock_->is_lockstep() ? run_lockstep(leaves) : run_real(leaves);
  } catch (const net::ClockLost&) {
    throw;
  } catch (const std::exception& e) {  // no flag, file or configuration is to blame any more
    std::fprintf(stderr, "arm_controller: gives up: %s\n", e.what());
    return kInternalError;
  }
}

// The arm is brought to rest before the program goes; a stop that takes too long is given to the drives.
bool Program::is_done(const std::atomic<bool>& leaves, Time now) {
  if (loop_->bus_is_lost()) {
    std::fprintf(stderr, "arm_controller: the bus %s is gone\n", bus_->name().c_str());
    exit_code_ = 3;
    return true;
  }
  if (!leaves && !gives_up_) return false;
  if (!leave_by_) {
    mailboxes_.stop.set();
    leave_by_ = now + kLongestStop;
    return false;
  }
  const bool is_moving = loop_->mode() == Mode::kServo || loop_->mode() == Mode::kStopping;
  return !is_moving || now > *leave_by_;
}

void Program::say_goodbye() { link_->close(clock_->now()); }

int Program::run_lockstep(const std::atomic<bool>& leaves) {
  while (true) {
    const Time now = clock_->wait_next_cycle();
    link_->step(now);
    loop_->cycle(now, clock_->missed());
    link_->publish(now);
    // Simulated time runs as fast as it can: the tape must not lose ticks because the disk is slow.
    if (tape_.ticks.size() > decltype(tape_.ticks)::capacity() / 2) files_->wait_idle();
    if (is_done(leaves, now)) break;
  }
  if (exit_code_ == 0) loop_->leave(clock_->now());
  say_goodbye();
  return exit_code_;
}

int Program::run_real(const std::atomic<bool>& leaves) {
  service_manager_.say_ready(bus_->name());
  if (!run_both([&] { cycle_thread(leaves); }, [this] { link_thread(); }, gives_up_)) return kInternalError;
  link_->publish(clock_->now());
  say_goodbye();
  return exit_code_;
}

void Program::link_thread() {
  const Duration link_period = std::max(kShortestLinkPeriod, seconds_to_duration(robot_.controller.period_s) / 2);
  while (!cycle_ended_ && !gives_up_) {
    const std::vector<int> descriptors = link_->descriptors();
    net::wait_readable(descriptors, link_period);
    link_->step(clock_->now());
    link_->publish(clock_->now());
    service_manager_.say_alive(clock_->now(), statistics_.cycles);
  }
  service_manager_.say_stopping();
}

bool Program::set_up_real_time() {
  std::vector<NotGranted> all = lock_memory();
  for (const NotGranted& refused : become_real_time(cpu_)) all.push_back(refused);
  machine_.emplace(cpu_);
  for (const NotGranted& refused : machine_->not_granted()) all.push_back(refused);
  bool is_enough = true;
  for (const NotGranted& refused : all) {
    std::fprintf(stderr, "arm_controller: real time: %s%s\n", refused.is_needed ? "NOT GRANTED: " : "",
                 refused.sentence.c_str());
    is_enough = is_enough && !refused.is_needed;
  }
  if (all.empty()) std::fprintf(stderr, "arm_controller: real time: all that was asked for was granted\n");
  if (requires_real_time_ && !is_enough) std::fprintf(stderr, "arm_controller: --require-rt: refused, see above\n");
  return is_enough || !requires_real_time_;
}

void Program::cycle_thread(const std::atomic<bool>& leaves) {
  if (!set_up_real_time()) exit_code_ = 2;
  try {
    while (exit_code_ != 2) {
      const Time now = clock_->wait_next_cycle();
      statistics_.wake_up.add(clock_->lateness());
      loop_->cycle(now, clock_->missed());
      if (is_done(leaves, now)) break;
    }
    if (exit_code_ == 0) loop_->leave(clock_->now());
  } catch (const net::ClockLost& e) {
    std::fprintf(stderr, "arm_controller: %s\n", e.what());
    exit_code_ = 3;
  }
  cycle_ended_ = true;
}

}  // namespace armsight::arm
