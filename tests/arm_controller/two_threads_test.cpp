// What one thread throws ends both, in order, and never the program.
#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "arm_controller/two_threads.hpp"

namespace armsight::arm::test {
namespace {

void fail() { throw std::length_error("message of 70000 bytes"); }

TEST(TwoThreads, EndTogetherWhenOneThrows) {
  for (const bool is_aside : {true, false}) {
    std::atomic<bool> gives_up{false};
    bool came_to_rest = false;
    const auto heed = [&] {
      while (!gives_up) std::this_thread::yield();
      came_to_rest = true;
    };
    testing::internal::CaptureStderr();
    EXPECT_FALSE(is_aside ? run_both(fail, heed, gives_up) : run_both(heed, fail, gives_up));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "arm_controller: gives up: message of 70000 bytes\n");
    EXPECT_TRUE(came_to_rest);
  }
}

TEST(TwoThreads, ThatEndAsAskedSayNothing) {
  std::atomic<bool> gives_up{false};
  EXPECT_TRUE(run_both([] {}, [] {}, gives_up));
}

}  // namespace
}  // namespace armsight::arm::test
