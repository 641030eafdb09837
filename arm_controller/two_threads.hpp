// Two threads that end together: an exception on one must bring the arm to rest on the other, never end the program
// with a drive enabled.
#pragma once

#include <atomic>
#include <functional>

namespace armsight::arm {

/// Runs `aside` on a thread of its own and `here` on this one; returns when both have ended. What either throws is said
/// on stderr and sets `gives_up`, which the other must heed. True: neither threw.
bool run_both(const std::function<void()>& aside, const std::function<void()>& here, std::atomic<bool>& gives_up);

}  // namespace armsight::arm
