// Sees what a thread asks of heap and locks: malloc and its kin, free, pthread_mutex_lock themselves are watched.
// Not under sanitizers, which bring their own.
#pragma once

#include <cstddef>

namespace armsight::arm::test {

struct Watched {
  std::size_t allocations = 0, frees = 0, locks = 0;
};

/// From now on, of this thread.
void begin_watch();
/// Ends it; the counts since the last call of this function.
Watched end_watch();
/// Interrupts it, keeping the counts.
void pause_watch();

}  // namespace armsight::arm::test
