#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace truepose::daemon {

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

 private:
  static constexpr std::size_t kSubBuckets = 32;
  static constexpr std::size_t kOctaves = 64;
  static std::size_t bucket(std::uint64_t ns) noexcept;
  static double upper_edge_ns(std::size_t bucket) noexcept;

  std::array<std::atomic<std::uint32_t>, kOctaves * kSubBuckets> counts_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace truepose::daemon
