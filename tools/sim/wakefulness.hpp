// Keeps the processors from sleeping while the simulator runs at the machine's pace. A virtual machine's processor that
// has gone to sleep may come back 5 to 20 ms late, which no real-time priority helps: measured on two virtual cores,
// wake-ups of a 2 kHz loop over 4 ms late: 8 in 10 s without, none with this. Costs every idle moment of the machine.
#pragma once

#include <thread>
#include <vector>

namespace armsight::sim {

class Wakefulness {
 public:
  /// One thread a processor, SCHED_IDLE: it runs only when nothing else wants to. None where that is not granted.
  Wakefulness();

 private:
  std::vector<std::jthread> idlers_;
};

}  // namespace armsight::sim
