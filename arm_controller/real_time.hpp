// What the operating system can give a loop at the drives' rate: asked for, reported, not assumed. Small stacks, one heap
// and locked memory for the process; SCHED_FIFO and a CPU for the thread of the cycle (machine_set_up: what the machine
// itself must be told).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace armsight::arm {

inline constexpr int kCyclePriority = 80;  ///< of SCHED_FIFO

/// One thing that was not granted.
struct NotGranted {
  std::string sentence;    ///< what, why, and what to do
  bool is_needed = false;  ///< --require-rt refuses to run without it
};

/// Before any thread is started and anything large is allocated; never fails.
void prepare_memory();
/// Locks all memory of the process, now and later.
std::vector<NotGranted> lock_memory();
/// For the calling thread: touches its stack, binds it to a CPU where one is asked for, makes it SCHED_FIFO.
std::vector<NotGranted> become_real_time(std::optional<int> cpu, int priority = kCyclePriority);

}  // namespace armsight::arm
