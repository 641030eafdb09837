// The hand-over between the two threads without a lock: newest values in slots, events in bounded rings. One writer
// and one reader each; nobody ever waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace armsight::arm {

/// The newest value of one kind. Three buffers: the writer's, the reader's, and the one in between.
template <typename T>
class Slot {
 public:
  /// What the reader had not taken comes back: whoever sent it must learn that it was replaced.
  std::optional<T> put(const T& value) noexcept {
    buffers_[back_] = value;
    const std::uint8_t old = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel);
    back_ = old & kIndex;
    if (old & kFresh) return buffers_[back_];
    return std::nullopt;
  }

  std::optional<T> take() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return std::nullopt;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return buffers_[front_];
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;
  std::array<T, 3> buffers_{};
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t back_ = 0, front_ = 2;
};

/// A request that cannot get lost: set until it is taken.
class StickyFlag {
 public:
  void set() noexcept { flag_.store(true, std::memory_order_release); }
  bool take() noexcept { return flag_.exchange(false, std::memory_order_acq_rel); }

 private:
  std::atomic<bool> flag_{false};
};

/// Bounded queue; a full one refuses and counts.
template <typename T, std::size_t kCapacity>
class Ring {
 public:
  bool push(const T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == kCapacity) {
      overflows_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    items_[head % kCapacity] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  bool pop(T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    value = items_[tail % kCapacity];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  std::size_t size() const noexcept {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_acquire);
  }
  static constexpr std::size_t capacity() noexcept { return kCapacity; }
  std::uint64_t overflows() const noexcept { return overflows_.load(std::memory_order_relaxed); }

 private:
  std::array<T, kCapacity> items_{};
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::atomic<std::uint64_t> overflows_{0};
};

}  // namespace armsight::arm
