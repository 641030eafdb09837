// What the operating system can give a 250 Hz loop: locked memory and a real-time priority. Tried, reported, not assumed.
#pragma once

#include <string>
#include <vector>

namespace armsight::arm {

/// For the calling thread; answers what failed, one sentence each (empty: everything was granted).
std::vector<std::string> become_real_time();

}  // namespace armsight::arm
