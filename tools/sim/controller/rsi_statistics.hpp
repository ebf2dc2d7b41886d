#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tools/sim/controller/rsi_client.hpp"

namespace truepose::sim {

/// Times from a datagram to its answer, counted by the microsecond.
class TurnaroundHistogram {
 public:
  void record(std::chrono::nanoseconds turnaround);
  void add(const TurnaroundHistogram& other);

  /// The smallest time, in whole microseconds rounded up, that this share of the answers did not exceed; 0
  /// without any.
  std::int64_t percentile_us(double share) const;
  std::int64_t max_us() const { return max_us_; }

  /// How many answers took so many whole microseconds, rounded up; those that none took left out. The
  /// difference of two such lists is that of the time between them.
  std::vector<std::pair<std::int64_t, std::uint32_t>> counts() const;

 private:
  // Slower answers share the last bin; max_us() knows the slowest.
  static constexpr std::size_t kBins = 50'000;

  std::vector<std::uint32_t> bins_ = std::vector<std::uint32_t>(kBins);
  std::uint64_t count_ = 0;
  std::int64_t max_us_ = 0;
};

/// Replies to other controllers that send to the same PC.
struct SecondSenders {
  std::uint64_t cycles = 0;
  std::uint64_t answered = 0;
  double max_step_rad = 0;  ///< of a correction that they had in effect

  void add(const RsiCounters& counters);
  void add(const SecondSenders& other);
};

/// What the RSI sessions of a simulator's life came to.
struct RsiStatistics {
  RsiCounters counters;
  SecondSenders second_senders;
  TurnaroundHistogram turnaround;
  double correction_in_effect_rad = 0;  ///< greatest of an axis; 0 while RSI is off
  std::uint64_t sessions = 0;
  std::uint64_t timeouts = 0;  ///< sessions that ended with KSS29002
  std::uint64_t overruns = 0;  ///< ticks that the simulator itself missed
  std::chrono::nanoseconds longest_overrun{0};
  std::uint64_t last_cycle = 0;  ///< of the simulator's life, whose faults have begun

  void add(const RsiStatistics& other);
};

}  // namespace truepose::sim
