#include "arm_controller/two_threads.hpp"

#include <cstdio>
#include <exception>
#include <thread>

namespace armsight::arm {
namespace {

void run_guarded(const std::function<void()>& work, std::atomic<bool>& gives_up) {
  try {
    work();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "arm_controller: gives up: %s\n", e.what());
    gives_up = true;
  }
}

}  // namespace

bool run_both(const std::function<void()>& aside, const std::function<void()>& here, std::atomic<bool>& gives_up) {
  {
    const std::jthread other([&] { run_guarded(aside, gives_up); });
    run_guarded(here, gives_up);
  }
  return !gives_up;
}

}  // namespace armsight::arm
