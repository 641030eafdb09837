// Sees what a thread asks of heap and locks: malloc and its kin, free, pthread_mutex_lock themselves are watched.
// Under a sanitizer, which brings its own, nothing is seen.
#pragma once

#include <cstddef>

namespace armsight::arm::test {

struct Watched {
  std::size_t allocations = 0, frees = 0, locks = 0;
  std::size_t largest_bytes = 0;  ///< asked for at once
};

bool can_watch();
/// From now on, of this thread.
void begin_watch();
/// Ends it; the counts since the last call of this function.
Watched end_watch();
/// Interrupts it, keeping the counts.
void pause_watch();

}  // namespace armsight::arm::test
