// Who asks for memory, and for how much at once? Counts this thread's calls of malloc while one of these lives; under a
// sanitizer, which has a malloc of its own, nothing is seen.
#pragma once

#include <cstddef>

namespace armsight::faults {

class AllocationWatch {
 public:
  AllocationWatch();
  ~AllocationWatch();
  AllocationWatch(const AllocationWatch&) = delete;
  AllocationWatch& operator=(const AllocationWatch&) = delete;

  std::size_t count() const;
  std::size_t largest() const;
  static bool sees();
};

}  // namespace armsight::faults
