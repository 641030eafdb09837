// The cycle allocates nothing, frees nothing and locks nothing: malloc, free and pthread_mutex_lock themselves are
// watched while it runs.
#include <gtest/gtest.h>

#include <mutex>

#include "tests/arm_controller/socket_rig.hpp"
#include "tests/arm_controller/watch.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace armsight::arm::test {
namespace {

TEST(Allocation, TheWatchSeesMallocFreeAndLock) {
  std::mutex mutex;
  begin_watch();
  int* volatile one = new int(1);
  delete one;
  mutex.lock();
  const Watched watched = end_watch();
  mutex.unlock();
  EXPECT_EQ(watched.allocations, 1u);
  EXPECT_EQ(watched.frees, 1u);
  EXPECT_EQ(watched.locks, 1u);
}

// From the first SYNC on: bring-up, self-check, power, every kind of order, a stop; bus, tapes and mailboxes included.
TEST(Allocation, CyclesWithEveryKindOfOrderAllocateAndLockNothing) {
  SocketRig rig;
  const bool is_done = rig.work([] { begin_watch(); }, [] { pause_watch(); });
  const Watched watched = end_watch();
  EXPECT_TRUE(is_done);
  EXPECT_EQ(watched.allocations, 0u);
  EXPECT_EQ(watched.frees, 0u);
  EXPECT_EQ(watched.locks, 0u);
}

}  // namespace
}  // namespace armsight::arm::test

#endif
