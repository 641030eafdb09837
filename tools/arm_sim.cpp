// arm_sim: the simulated robot as a program. Exit codes: 0 finished or stopped, 2 bad flag or file, 3 bus lost or a
// socket that cannot be had.
#include <csignal>
#include <cstdio>

#include "tools/sim/arm_sim_flags.hpp"
#include "tools/sim/camera_server.hpp"
#include "tools/sim/simulation.hpp"

namespace {

volatile std::sig_atomic_t is_stopping = 0;
void stop(int) { is_stopping = 1; }

armsight::sim::SimulationOptions load(const armsight::sim::ArmSimFlags& flags) {
  armsight::sim::SimulationOptions options;
  options.robot = armsight::load_robot(flags.robot_file);
  if (flags.rate_hz) options.robot.controller.period_s = 1.0 / *flags.rate_hz;
  options.scene = armsight::sim::load_scene(flags.scene_file);
  options.noise = flags.noise;
  options.mount = flags.mount;
  options.seed = flags.seed;
  options.is_lockstep = flags.is_lockstep;
  options.clock_path = flags.clock_path;
  options.emulated_bus_paths = flags.emulated_bus_paths;
  options.can_interfaces = flags.can_interfaces;
  options.log_file = flags.log_file;
  return options;
}

int run(const armsight::sim::ArmSimFlags& flags) {
  using namespace armsight::sim;
  const SimulationOptions options = load(flags);
  Simulation simulation(options);
  CameraServer camera(flags.camera_address, simulation.clock(), options.scene, options.robot.hand_marker,
                      noise_figures(flags.noise), flags.seed, simulation.to_own_clock());
  const std::string host = flags.camera_address.substr(0, flags.camera_address.rfind(':'));
  std::printf("arm_sim: bus %s, %.0f kbit/s\n", simulation.bus_name().c_str(),
              options.robot.controller.bus_bitrate_bit_s / 1000.0);
  std::printf("arm_sim: camera %s:%u\n", host.c_str(), camera.port());
  std::printf("arm_sim: ready\n");
  std::fflush(stdout);
  const auto end = simulation.run(
      [&camera](std::int64_t sim_time_ns, const WorldAt& world_at) { camera.advance(sim_time_ns, world_at); },
      [] { return is_stopping != 0; });
  if (end != Simulation::End::kBusLost) return 0;
  std::fprintf(stderr, "arm_sim: %s is lost\n", simulation.bus_name().c_str());
  return 3;
}

}  // namespace

int main(int argc, char** argv) {
  armsight::sim::ArmSimFlags flags;
  if (const auto code = armsight::sim::parse_flags(argc, argv, flags)) return *code;
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  try {
    return run(flags);
  } catch (const armsight::ConfigError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "arm_sim: %s\n", error.what());
    return 3;
  }
}
