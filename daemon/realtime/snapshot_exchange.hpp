#pragma once

#include <array>
#include <atomic>

namespace truepose::daemon {

/// Hands the newest value from one writing thread to one reading thread. Neither ever waits for the other.
///
/// A triple buffer: the writer fills its own slot and swaps it with the one in the middle; the reader swaps
/// its own with the middle when that is fresh. Values in between are dropped. A slot is reused, so that
/// writing a value that allocates is the writer's business alone, and the reader never frees one.
template <typename T>
class SnapshotExchange {
 public:
  /// The writer's slot. It holds an old value, to be overwritten before publish().
  T& back() noexcept { return slots_[back_].value; }

  /// Makes back() the newest value.
  void publish() noexcept { back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex; }

  /// Moves front() to the newest value. @return whether it is one that the reader has not seen
  bool take() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// The reader's slot: default-constructed until the first take(), and untouched by the writer until the
  /// next.
  const T& front() const noexcept { return slots_[front_].value; }

 private:
  static constexpr unsigned kIndex = 3;
  static constexpr unsigned kFresh = 4;
  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_;
  alignas(64) std::atomic<unsigned> middle_{1};
  alignas(64) unsigned back_ = 0;
  alignas(64) unsigned front_ = 2;
};

}  // namespace truepose::daemon
