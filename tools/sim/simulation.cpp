#include "tools/sim/simulation.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <deque>
#include <optional>
#include <thread>
#include <utility>

#include "arm_controller/real_time.hpp"
#include "arm_controller/socket_can.hpp"
#include "tools/sim/bus_hub.hpp"
#include "tools/sim/bus_log.hpp"
#include "tools/sim/sim_clock_server.hpp"
#include "tools/sim/truth_file.hpp"
#include "tools/sim/wakefulness.hpp"
#include "tools/sim/world.hpp"

namespace armsight::sim {

namespace {

constexpr Duration kRealStep = std::chrono::milliseconds(1);
constexpr Duration kLongestStep = std::chrono::milliseconds(5);
constexpr Duration kNeedsWakefulness = std::chrono::milliseconds(10);
constexpr Duration kStall = std::chrono::milliseconds(3);  ///< later than this is the machine's doing
constexpr Duration kCameraStep = std::chrono::milliseconds(2);
constexpr Duration kInstant{1};
constexpr int kBusPriority = arm::kCyclePriority + 5;  // drives do not wait for programs

}  // namespace

struct Simulation::Impl {
  explicit Impl(const SimulationOptions& o);

  SimulationOptions options;
  SimClockServer server;
  std::deque<BusModel> buses;              ///< emulated: one for each of the robot's
  World world;
  std::vector<std::unique_ptr<BusHub>> hubs;
  std::vector<std::unique_ptr<arm::CanBus>> interfaces;  ///< or real ones
  std::vector<std::size_t> bus_of_node;
  std::vector<int> node_ports;
  std::unique_ptr<BusLog> log;
  bool is_lost = false;
  int stalls = 0;
  Duration longest_stall{0};

  Duration period() const { return seconds_to_duration(options.robot.controller.period_s); }
  /// What waits for a frame is woken by it; the step is for the arm's own motion.
  Duration real_step() const { return std::clamp(period() / 4, kRealStep, kLongestStep); }
  Time start() const { return options.is_lockstep ? time_from_ns(kFirstTime_ns) : time_from_ns(net::monotonic_ns()); }
  void attach_nodes();
  void open_log();
  void open_buses();
  Time next_frame();
  void note(const CanFrame& frame, Time time, std::size_t bus);
  void send_from_node(std::size_t node, const CanFrame& frame, Time now);
  void simulate_until(Time until);
  void receive_from_interfaces();
  std::string finish(const std::string& file);
  WorldAt world_at() const;
  bool run_lockstep(const AdvanceCamera& advance_camera, const std::function<bool()>& is_stopping);
  bool run_real(const std::function<bool()>& is_stopping);
  void wait_real();
  void excuse_stall(Time last, Time now);
  void report_stalls() const;
};

Simulation::Impl::Impl(const SimulationOptions& o)
    : options(o),
      server({o.clock_path, o.is_lockstep, seconds_to_duration(o.robot.controller.period_s), o.seed},
             {[this] { return world.inject_drift(server.clock().now()), std::string(); },
              [this](const std::string& file) { return finish(file); }}),
      world(o.robot, o.scene, make_truth(o.robot, o.scene, o.noise, o.mount, o.seed), start(),
            [this](std::size_t node, const CanFrame& frame, Time now) { send_from_node(node, frame, now); }) {
  open_buses();
  open_log();
  attach_nodes();
  world.power_on(start());
}

void Simulation::Impl::open_buses() {
  const SimulationOptions& o = options;
  const auto given = static_cast<int>(o.can_interfaces.size() + o.emulated_bus_paths.size());
  if (given != o.robot.bus_count())
    throw ConfigError("buses given: " + std::to_string(given) + ", the robot file has drives on " +
                      std::to_string(o.robot.bus_count()));
  const ToOwnClock to_own = [this](std::uint32_t id, std::int64_t ns) { return server.to_own_ns(id, ns); };
  for (const std::string& name : o.can_interfaces)
    interfaces.push_back(arm::open_socket_can(name, server.clock(), arm::CanHears::kEverything,
                                              o.robot.has_fd_drive(static_cast<int>(interfaces.size()))));
  for (const std::string& path : o.emulated_bus_paths) {
    BusModel& bus = buses.emplace_back(bus_rates(o.robot));
    hubs.push_back(std::make_unique<BusHub>(path, bus, server.clock(), to_own, static_cast<int>(hubs.size())));
  }
}

void Simulation::Impl::open_log() {
  if (options.log_file.empty()) return;
  log = std::make_unique<BusLog>(options.log_file);
  for (std::size_t i = 0; i < buses.size(); ++i)
    buses[i].add_port([this, i](const CanFrame& frame, Time end, bool) { note(frame, end, i); });
}

void Simulation::Impl::note(const CanFrame& frame, Time time, std::size_t bus) {
  if (!log) return;
  const std::string emulated = bus == 0 ? "emulated" : "emulated" + std::to_string(bus);
  log->add({time, interfaces.empty() ? emulated : options.can_interfaces[bus], frame, false});
}

void Simulation::Impl::attach_nodes() {
  for (const DriveConfig& drive : options.robot.drives) bus_of_node.push_back(drive.bus);
  bus_of_node.push_back(options.robot.hand.bus);
  for (std::size_t i = 0; interfaces.empty() && i < world.node_count(); ++i)
    node_ports.push_back(buses[bus_of_node[i]].add_port([this, i](const CanFrame& frame, Time end, bool is_own_echo) {
      if (is_own_echo) return;
      world.advance_to(end);
      world.on_frame(i, frame, end);
    }, BusModel::Order::kByPriority));
}

void Simulation::Impl::send_from_node(std::size_t node, const CanFrame& frame, Time now) {
  if (interfaces.empty()) {
    // A full queue drops the frame, as in a drive's mailbox.
    buses[bus_of_node[node]].send(node_ports[node], frame, now);
    return;
  }
  interfaces[bus_of_node[node]]->send(frame);  // noted when it comes back as our own
}

Time Simulation::Impl::next_frame() {
  Time next = kNever;
  for (BusModel& bus : buses) next = std::min(next, bus.next_event());
  return next;
}

/// Events in order of time: the end of a frame, or a node's timer.
void Simulation::Impl::simulate_until(Time until) {
  while (true) {
    const Time timer = world.next_time();
    const Time frame = next_frame();
    if (std::min(timer, frame) >= until) break;
    if (timer <= frame) world.advance_to(timer);
    else
      for (BusModel& bus : buses) bus.run_until(frame + kInstant);
  }
  world.advance_to(until);
}

std::string Simulation::Impl::finish(const std::string& file) {
  const std::uint32_t arm = server.last_arm_controller();
  try {
    write_truth(world, file, [this, arm](Time t) { return server.to_own_ns(arm, to_ns(t)); }, server.clock().now());
    if (log) log->flush();
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

WorldAt Simulation::Impl::world_at() const {
  return [this](double time_s) { return world.plant().view(time_s); };
}

bool Simulation::Impl::run_lockstep(const AdvanceCamera& advance_camera, const std::function<bool()>& is_stopping) {
  const WorldAt at = world_at();
  const Duration period = this->period();
  while (server.run_participants(is_stopping)) {
    const Time end = server.clock().now() + period;
    for (auto& hub : hubs) hub->receive();
    simulate_until(end);
    server.clock().set_now(end - kInstant);  // frames sent now arrive within this cycle
    advance_camera(to_ns(end), at);
    server.end_cycle();
  }
  return server.is_finished();
}

void Simulation::Impl::receive_from_interfaces() {
  const Time now = server.clock().now();
  arm::BusFrame received;
  for (std::size_t bus = 0; bus < interfaces.size(); ++bus) {
    while (interfaces[bus]->receive(received)) {
      note(received.frame, received.time, bus);
      for (std::size_t i = 0; !received.is_own_echo && i < world.node_count(); ++i)
        if (bus_of_node[i] == bus) world.on_frame(i, received.frame, now);
    }
    is_lost = is_lost || interfaces[bus]->take_errors().lost;
  }
}

void Simulation::Impl::wait_real() {
  std::vector<int> descriptors = server.descriptors();
  for (const auto& hub : hubs) {
    const std::vector<int> of_bus = hub->descriptors();
    descriptors.insert(descriptors.end(), of_bus.begin(), of_bus.end());
  }
  const Time now = server.clock().now();
  for (const auto& interface : interfaces) descriptors.push_back(interface->descriptor());
  const Time wake = std::min({now + real_step(), next_frame(), world.next_time()});
  net::wait_and_flow(descriptors, std::max(Duration::zero(), wake - now), nullptr);
}

/// A real drive's firmware is never stopped by a busy host. What the machine takes from the simulator is therefore not
/// counted as silence on the bus; it is counted here, and said at the end.
void Simulation::Impl::excuse_stall(Time last, Time now) {
  const Duration stall = now - last - real_step();
  if (stall < kStall) return;
  world.excuse(stall);
  ++stalls;
  longest_stall = std::max(longest_stall, stall);
}

void Simulation::Impl::report_stalls() const {
  if (stalls == 0) return;
  std::fprintf(stderr, "arm_sim: the machine stopped the simulator %d times, for up to %.1f ms\n", stalls,
               to_seconds(longest_stall) * 1e3);
}

bool Simulation::Impl::run_real(const std::function<bool()>& is_stopping) {
  Time last = server.clock().now();
  while (!server.is_finished() && !is_stopping() && !is_lost) {
    server.serve();
    const Time now = server.clock().now();
    excuse_stall(std::exchange(last, now), now);
    simulate_until(now);
    for (auto& hub : hubs) hub->receive();
    receive_from_interfaces();
    wait_real();
  }
  return server.is_finished();
}

Simulation::Simulation(const SimulationOptions& options) : impl_(std::make_unique<Impl>(options)) {}

Simulation::~Simulation() = default;

ServerClock& Simulation::clock() { return impl_->server.clock(); }

ToOwnClock Simulation::to_own_clock() const {
  return [this](std::uint32_t id, std::int64_t ns) { return impl_->server.to_own_ns(id, ns); };
}

std::string Simulation::bus_name() const {
  std::string text;
  for (const auto& interface : impl_->interfaces) text += (text.empty() ? "" : " + ") + interface->name();
  for (const std::string& path : impl_->options.emulated_bus_paths)
    text += (text.empty() ? "" : " + ") + std::string("emulated:") + path;
  return text;
}

Simulation::End Simulation::run(const AdvanceCamera& advance_camera, const std::function<bool()>& is_stopping) {
  bool is_finished = false;
  if (impl_->options.is_lockstep) {
    is_finished = impl_->run_lockstep(advance_camera, is_stopping);
  } else {
    std::jthread camera([this, &advance_camera](const std::stop_token& stop) {
      const WorldAt at = impl_->world_at();
      const Duration step = std::max(kCameraStep, impl_->real_step());
      while (!stop.stop_requested()) {
        advance_camera(to_ns(impl_->server.clock().now()), at);
        std::this_thread::sleep_for(step);
      }
    });
    std::optional<Wakefulness> wakefulness;
    if (impl_->period() <= kNeedsWakefulness) wakefulness.emplace();
    std::vector<arm::NotGranted> refused = arm::lock_memory();
    for (const arm::NotGranted& item : arm::become_real_time(std::nullopt, kBusPriority)) refused.push_back(item);
    for (const arm::NotGranted& item : refused) std::fprintf(stderr, "arm_sim: %s\n", item.sentence.c_str());
    is_finished = impl_->run_real(is_stopping);
    impl_->report_stalls();
  }
  if (impl_->is_lost) return End::kBusLost;
  return is_finished ? End::kFinished : End::kStopped;
}

}  // namespace armsight::sim
