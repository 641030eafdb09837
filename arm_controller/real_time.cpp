#include "arm_controller/real_time.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace armsight::arm {
namespace {

// Locked memory is there as a whole: of the usual 8 MB a thread every byte. Deepest use seen: 30 kB.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::size_t kThreadStack = 8 * 1024 * 1024;  // their frames are many times as large
#else
constexpr std::size_t kThreadStack = 256 * 1024;
#endif

void touch_stack() {
  volatile char page[64 * 1024];
  for (std::size_t i = 0; i < sizeof page; i += 1024) page[i] = 0;
}

}  // namespace

void prepare_memory() {
  mallopt(M_ARENA_MAX, 1);  // a heap for each thread is memory that nobody else can use; the cycle uses none
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  if (pthread_attr_setstacksize(&attributes, kThreadStack) == 0) pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

std::vector<NotGranted> lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return {{std::string("memory is not locked (mlockall: ") + std::strerror(errno) +
               "): allow it by LimitMEMLOCK=infinity, ulimit -l unlimited or CAP_IPC_LOCK",
           true}};
}

std::vector<NotGranted> become_real_time(std::optional<int> cpu, int priority) {
  std::vector<NotGranted> failed;
  touch_stack();
  cpu_set_t only;
  CPU_ZERO(&only);
  if (cpu) CPU_SET(static_cast<std::size_t>(*cpu), &only);
  if (const int error = cpu ? pthread_setaffinity_np(pthread_self(), sizeof only, &only) : 0; error != 0)
    failed.push_back({"the cycle is not bound to CPU " + std::to_string(*cpu) + " (" + std::strerror(error) +
                          "): --cpu must name one of /sys/devices/system/cpu/online that the service may use",
                      true});
  sched_param parameter{};
  parameter.sched_priority = priority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter); error != 0)
    failed.push_back({"no real-time priority (SCHED_FIFO " + std::to_string(priority) + ": " + std::strerror(error) +
                          "): allow it by LimitRTPRIO=90, ulimit -r 90 or CAP_SYS_NICE",
                      true});
  return failed;
}

}  // namespace armsight::arm
