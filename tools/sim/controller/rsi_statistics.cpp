#include "tools/sim/controller/rsi_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace truepose::sim {

void TurnaroundHistogram::record(std::chrono::nanoseconds turnaround) {
  const std::int64_t us =
      std::max<std::int64_t>(0, std::chrono::ceil<std::chrono::microseconds>(turnaround).count());
  ++bins_[std::min(static_cast<std::size_t>(us), kBins - 1)];
  ++count_;
  max_us_ = std::max(max_us_, us);
}

void TurnaroundHistogram::add(const TurnaroundHistogram& other) {
  std::ranges::transform(bins_, other.bins_, bins_.begin(), std::plus{});
  count_ += other.count_;
  max_us_ = std::max(max_us_, other.max_us_);
}

std::int64_t TurnaroundHistogram::percentile_us(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t us = 0; us + 1 < kBins; ++us) {
    seen += bins_[us];
    if (seen >= wanted) return static_cast<std::int64_t>(us);
  }
  return max_us_;
}

std::vector<std::pair<std::int64_t, std::uint32_t>> TurnaroundHistogram::counts() const {
  std::vector<std::pair<std::int64_t, std::uint32_t>> counts;
  for (std::size_t us = 0; us < kBins; ++us) {
    if (bins_[us] > 0) counts.emplace_back(us, bins_[us]);
  }
  return counts;
}

void SecondSenders::add(const RsiCounters& counters) {
  add(SecondSenders{counters.cycles, counters.answered, counters.max_step_rad});
}

void SecondSenders::add(const SecondSenders& other) {
  cycles += other.cycles;
  answered += other.answered;
  max_step_rad = std::max(max_step_rad, other.max_step_rad);
}

void RsiStatistics::add(const RsiStatistics& other) {
  counters.cycles += other.counters.cycles;
  counters.answered += other.counters.answered;
  counters.late += other.counters.late;
  counters.lost += other.counters.lost;
  counters.wrong_ipoc += other.counters.wrong_ipoc;
  counters.rejected += other.counters.rejected;
  counters.clamped += other.counters.clamped;
  counters.max_step_rad = std::max(counters.max_step_rad, other.counters.max_step_rad);
  counters.correction_rad = other.counters.correction_rad;  // of the session that came last
  second_senders.add(other.second_senders);
  turnaround.add(other.turnaround);
  sessions += other.sessions;
  timeouts += other.timeouts;
  overruns += other.overruns;
  longest_overrun = std::max(longest_overrun, other.longest_overrun);
  last_cycle = std::max(last_cycle, other.last_cycle);
}

}  // namespace truepose::sim
