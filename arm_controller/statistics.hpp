// What the cycle tells of itself, always: counts and durations since the start. Written by the cycle thread, read by the
// link, which sends them every second.
#pragma once

#include "arm_controller/drive_master.hpp"
#include "arm_controller/histogram.hpp"

namespace armsight::arm {

struct LoopStatistics {
  Histogram wake_up;      ///< from when a cycle was due to when it began; at real pace only
  Histogram tick;         ///< the tick alone, on the machine's clock
  Histogram sync_period;  ///< how far from the configured period two own echoes of SYNC are apart
  std::array<Histogram, DriveMaster::kMaxNodes> tpdo1;  ///< from SYNC to TPDO1 (of a DAMIAO motor: from its
                                                        ///< command to its sample); joints, then the hand
  std::atomic<std::uint64_t> cycles{0};
  std::atomic<std::uint64_t> missed{0};
  std::atomic<std::uint64_t> bus_send_failures{0};
  std::atomic<std::uint64_t> tape_overflows{0};
};

}  // namespace armsight::arm
