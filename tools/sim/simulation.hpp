// arm_sim's loop: clock, bus, robot and camera together, in lockstep or at the machine's pace.
//
//   lockstep:  Grant(k) … Done(k) ► frames of k onto the bus ► [t_k, t_k+1): bus and robot, event by event ►
//              camera ► k+1
//   real:      whatever has come ► bus and robot up to now ► sleep until the next event; the camera has its own thread
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arm_controller/can_bus.hpp"
#include "tools/sim/truth.hpp"
#include "tools/sim/world_view.hpp"
#include "tools/sim/server_clock.hpp"

namespace armsight::sim {

struct SimulationOptions {
  RobotConfig robot;
  Scene scene;
  NoiseSet noise = NoiseSet::kNominal;
  CameraMount mount = CameraMount::kNear;
  std::uint64_t seed = 1;
  bool is_lockstep = true;
  std::string clock_path;
  std::vector<std::string> emulated_bus_paths;  ///< one for each bus of the robot; or
  std::vector<std::string> can_interfaces;      ///< real interfaces; they imply real pace
  std::filesystem::path log_file;     ///< candump -L text of the buses; empty: none
};

class Simulation {
 public:
  /// Throws std::runtime_error, ConfigError or arm::BusError when something cannot be opened.
  explicit Simulation(const SimulationOptions& options);
  ~Simulation();

  ServerClock& clock();
  ToOwnClock to_own_clock() const;
  std::string bus_name() const;

  /// Called with the end of each cycle (lockstep), or again and again from a thread of its own (real pace).
  using AdvanceCamera = std::function<void(std::int64_t sim_time_ns, const WorldAt& world_at)>;
  enum class End { kFinished, kStopped, kBusLost };
  End run(const AdvanceCamera& advance_camera, const std::function<bool()>& is_stopping);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace armsight::sim
