#include "arm_controller/real_time.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace armsight::arm {
namespace {

void touch_stack() {
  volatile char page[64 * 1024];
  for (std::size_t i = 0; i < sizeof page; i += 1024) page[i] = 0;
}

}  // namespace

std::vector<std::string> become_real_time(int priority) {
  std::vector<std::string> failed;
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    failed.push_back(std::string("memory is not locked (mlockall: ") + std::strerror(errno) + ")");
  touch_stack();
  sched_param parameter{};
  parameter.sched_priority = priority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter); error != 0)
    failed.push_back("no real-time priority (SCHED_FIFO " + std::to_string(priority) + ": " + std::strerror(error) + ")");
  return failed;
}

}  // namespace armsight::arm
