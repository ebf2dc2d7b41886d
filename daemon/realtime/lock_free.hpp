#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

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

/// Queue of plain records from one writing thread to one reading thread; neither waits. A record that finds
/// it full is dropped and counted.
template <typename T, std::size_t kCapacity>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T> && std::has_single_bit(kCapacity));

 public:
  /// Writer. @return false where the record was dropped
  bool push(const T& record) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == kCapacity) {
      dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      return false;
    }
    records_[tail % kCapacity] = record;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Reader. @return false where the queue is empty
  bool pop(T& record) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    record = records_[head % kCapacity];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Records lost so far. Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  std::array<T, kCapacity> records_{};
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) std::atomic<std::uint64_t> tail_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

/// Log-linear histogram of durations: every octave of nanoseconds in 32 parts, so a value read back is at
/// most 1/32 (3 %) too large. Written by one thread with one relaxed increment, read by any.
class LatencyHistogram {
 public:
  struct Summary {
    std::uint64_t count = 0;
    double p50_us = 0, p99_us = 0, p999_us = 0, max_us = 0;
  };

  /// Writer's thread. A negative duration counts as 0.
  void record(std::chrono::nanoseconds duration) noexcept;

  /// Any thread. Percentiles are upper edges of their bucket, never above the maximum, which is exact. 0
  /// where empty.
  Summary summary() const noexcept;

  /// How many durations were no longer than each of some edges, and how many and how long they are all
  /// together.
  struct Distribution {
    std::vector<std::uint64_t> at_most;
    std::uint64_t count = 0;
    double sum_us = 0;  ///< of the buckets' upper edges
  };
  /// Any thread.
  /// @param edges_us  ascending
  Distribution distribution(std::span<const double> edges_us) const;

 private:
  static constexpr std::size_t kSubBuckets = 32;
  static constexpr std::size_t kOctaves = 64;
  static std::size_t bucket(std::uint64_t ns) noexcept;
  static double upper_edge_ns(std::size_t bucket) noexcept;

  std::array<std::atomic<std::uint64_t>, kOctaves * kSubBuckets> counts_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace truepose::daemon
