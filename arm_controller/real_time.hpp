// What the operating system can give a loop at the drives' rate: locked memory and a real-time priority. Tried, reported,
// not assumed.
#pragma once

#include <string>
#include <vector>

namespace armsight::arm {

inline constexpr int kCyclePriority = 80;  ///< of SCHED_FIFO

/// For the calling thread; answers what failed, one sentence each (empty: everything was granted).
std::vector<std::string> become_real_time(int priority = kCyclePriority);

}  // namespace armsight::arm
