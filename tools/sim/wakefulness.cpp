#include "tools/sim/wakefulness.hpp"

#include <pthread.h>
#include <sched.h>

namespace armsight::sim {

namespace {

void idle_awake(const std::stop_token& stop, int processor) {
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(processor, &only);
  const sched_param none{};
  if (pthread_setaffinity_np(pthread_self(), sizeof only, &only) != 0) return;
  if (pthread_setschedparam(pthread_self(), SCHED_IDLE, &none) != 0) return;
  while (!stop.stop_requested()) {
  }
}

}  // namespace

Wakefulness::Wakefulness() {
  cpu_set_t granted;
  CPU_ZERO(&granted);
  if (sched_getaffinity(0, sizeof granted, &granted) != 0) return;
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(i, &granted)) idlers_.emplace_back([i](const std::stop_token& stop) { idle_awake(stop, i); });
  }
}

}  // namespace armsight::sim
