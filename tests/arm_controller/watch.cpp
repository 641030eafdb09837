#include "tests/arm_controller/watch.hpp"

#include <dlfcn.h>
#include <pthread.h>

namespace {

thread_local bool t_is_watched = false;
thread_local armsight::arm::test::Watched t_watched;

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

using Lock = int (*)(pthread_mutex_t*);
Lock g_lock = nullptr;  // of the C library; found at the first use, before the program has threads

void note_request(size_t bytes) {
  if (!t_is_watched) return;
  ++t_watched.allocations;
  if (bytes > t_watched.largest_bytes) t_watched.largest_bytes = bytes;
}

}  // namespace

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
void __libc_free(void* block);

void* malloc(size_t size) {
  note_request(size);
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  note_request(count * size);
  return __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  note_request(size);
  return __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  note_request(size);
  return __libc_memalign(alignment, size);
}
void free(void* block) {
  if (t_is_watched && block != nullptr) ++t_watched.frees;
  __libc_free(block);
}
int pthread_mutex_lock(pthread_mutex_t* mutex) {
  if (t_is_watched) ++t_watched.locks;
  if (g_lock == nullptr) g_lock = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  return g_lock(mutex);
}
}

bool armsight::arm::test::can_watch() { return true; }
#else
bool armsight::arm::test::can_watch() { return false; }
#endif

namespace armsight::arm::test {

void begin_watch() { t_is_watched = true; }
void pause_watch() { t_is_watched = false; }
Watched end_watch() {
  t_is_watched = false;
  const Watched watched = t_watched;
  t_watched = {};
  return watched;
}

}  // namespace armsight::arm::test
