#include "daemon/realtime/lock_free.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace truepose::daemon {

namespace {

constexpr int kSubBits = 5;

}  // namespace

// Values below 32 ns have a bucket each; above, the five bits after the leading one choose the bucket of the
// octave.
std::size_t LatencyHistogram::bucket(std::uint64_t ns) noexcept {
  if (ns < kSubBuckets) return ns;
  const int octave = static_cast<int>(std::bit_width(ns)) - kSubBits;
  return static_cast<std::size_t>(octave) * kSubBuckets + ((ns >> (octave - 1)) & (kSubBuckets - 1));
}

double LatencyHistogram::upper_edge_ns(std::size_t bucket) noexcept {
  if (bucket < kSubBuckets) return static_cast<double>(bucket);
  const int octave = static_cast<int>(bucket / kSubBuckets);
  return std::ldexp(static_cast<double>(kSubBuckets + bucket % kSubBuckets + 1), octave - 1) - 1;
}

void LatencyHistogram::record(std::chrono::nanoseconds duration) noexcept {
  const auto ns = static_cast<std::uint64_t>(std::max<std::chrono::nanoseconds::rep>(duration.count(), 0));
  std::atomic<std::uint64_t>& count = counts_[bucket(ns)];
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (ns > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(ns, std::memory_order_relaxed);
}

LatencyHistogram::Summary LatencyHistogram::summary() const noexcept {
  std::array<std::uint64_t, kOctaves * kSubBuckets> counts;
  Summary summary;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = counts_[i].load(std::memory_order_relaxed);
    summary.count += counts[i];
  }
  const double max_ns = static_cast<double>(max_ns_.load(std::memory_order_relaxed));
  const auto percentile_us = [&](double fraction) {
    const double rank = std::ceil(fraction * static_cast<double>(summary.count));
    double seen = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      seen += static_cast<double>(counts[i]);
      if (counts[i] > 0 && seen >= rank) return std::min(upper_edge_ns(i), max_ns) / 1e3;
    }
    return 0.0;
  };
  summary.p50_us = percentile_us(0.5);
  summary.p99_us = percentile_us(0.99);
  summary.p999_us = percentile_us(0.999);
  summary.max_us = max_ns / 1e3;
  return summary;
}

LatencyHistogram::Distribution LatencyHistogram::distribution(std::span<const double> edges_us) const {
  Distribution distribution{.at_most = std::vector<std::uint64_t>(edges_us.size())};
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const std::uint64_t count = counts_[i].load(std::memory_order_relaxed);
    if (count == 0) continue;
    const double longest_us = upper_edge_ns(i) / 1e3;
    distribution.count += count;
    distribution.sum_us += static_cast<double>(count) * longest_us;
    for (std::size_t edge = 0; edge < edges_us.size(); ++edge)
      if (longest_us <= edges_us[edge]) distribution.at_most[edge] += count;
  }
  return distribution;
}

}  // namespace truepose::daemon
