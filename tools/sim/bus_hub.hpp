// The emulated bus' socket end: programs join at an AF_UNIX path and become ports of the BusModel.
// Lockstep: exactly the frames that each participant reported as sent in this cycle go onto the bus at its start, and
// every frame delivered to it is counted. Observers see every frame with simulated time and count nowhere.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/sim/bus_model.hpp"
#include "tools/sim/server_clock.hpp"
#include "tools/sim/world_view.hpp"

namespace armsight::sim {

class BusHub {
 public:
  /// number: of this bus among the robot's.
  BusHub(const std::string& path, BusModel& bus, ServerClock& clock, ToOwnClock to_own, int number = 0);
  ~BusHub();

  /// Lockstep: takes what is due. Real pace: takes what has come. New programs are let in first.
  void receive();
  std::vector<int> descriptors() const;
  std::uint64_t frames_dropped() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace armsight::sim
