// What the simulated camera may know of the simulated world: true poses at one instant.
// The camera is the only reader; it asks for instants of the last 100 ms (mid-exposure, motion-blur sub-exposures).
#pragma once

#include <cstdint>
#include <functional>

#include "shared/geometry.hpp"
#include "tools/sim/noise.hpp"

namespace armsight::sim {

struct WorldView {
  double time_s = 0.0;        ///< simulated time
  Pose T_C_B, T_B_H, T_H_M, T_B_O;
  double hand_closure = 0.0;  ///< 0 open … 1 closed
};

/// Truth at a simulated time, interpolated between the plant's steps. Times outside the history are held at its ends.
/// Safe to call from another thread.
using WorldAt = std::function<WorldView(double sim_time_s)>;

/// Simulated time → the clock of a participant (its id from CameraHello; 0: simulated time itself).
using ToOwnClock = std::function<std::int64_t(std::uint32_t participant, std::int64_t sim_time_ns)>;

// arm_sim's loop calls CameraServer::advance(sim_time_ns, world_at) after each cycle with the cycle's end: exposures up
// to then are decided, frames whose latency is over are sent (FramedStream counts them on its channel). At real pace
// the camera has a thread of its own, so that rendering never delays the bus.

}  // namespace armsight::sim
