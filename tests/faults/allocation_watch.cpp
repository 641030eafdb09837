#include "tests/faults/allocation_watch.hpp"

#include <stddef.h>

namespace {
thread_local bool t_is_watched = false;
thread_local std::size_t t_count = 0, t_largest = 0;
}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
void* __libc_malloc(size_t size);
void* malloc(size_t size) {
  if (t_is_watched) {
    ++t_count;
    if (size > t_largest) t_largest = size;
  }
  return __libc_malloc(size);
}
}
bool armsight::faults::AllocationWatch::sees() { return true; }
#else
bool armsight::faults::AllocationWatch::sees() { return false; }
#endif

namespace armsight::faults {

AllocationWatch::AllocationWatch() {
  t_count = t_largest = 0;
  t_is_watched = true;
}
AllocationWatch::~AllocationWatch() { t_is_watched = false; }
std::size_t AllocationWatch::count() const { return t_count; }
std::size_t AllocationWatch::largest() const { return t_largest; }

}  // namespace armsight::faults
