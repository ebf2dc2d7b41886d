#include "core/data/clock_step.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include "core/data/measured_time.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewestTimes = 12;  // of which chance hardly makes two runs
constexpr double kLeastBack_s = 60;       // less turns no order round that matters
constexpr std::size_t kMostClockSteps = 2;
constexpr double kMeasuredAgain = 0.1;  // of the points

struct Timed {
  std::size_t point;
  double seconds;
};

/// The fewest that are out of order: all but the longest part that rises.
std::size_t out_of_order(std::span<const Timed> series) {
  std::vector<double> last;  // of a rising part of each length the least that it can end with
  for (const Timed& each : series) {
    const auto place = std::ranges::upper_bound(last, each.seconds);
    if (place == last.end())
      last.push_back(each.seconds);
    else
      *place = each.seconds;
  }
  return series.size() - last.size();
}

std::optional<ClockStep> step_of(std::span<const Timed> series) {
  if (series.size() < kFewestTimes) return std::nullopt;
  std::vector<ClockStep> back;
  for (std::size_t i = 1; i < series.size(); ++i) {
    const double by = series[i - 1].seconds - series[i].seconds;
    if (by > 0) back.push_back({series[i - 1].point, series[i].point, by});
  }
  if (back.empty() || back.size() > kMostClockSteps) return std::nullopt;
  const ClockStep widest = *std::ranges::max_element(back, {}, &ClockStep::back_s);
  const auto few = std::max<std::size_t>(
      kMostClockSteps, static_cast<std::size_t>(kMeasuredAgain * static_cast<double>(series.size())));
  const bool runs_on = widest.back_s >= kLeastBack_s && out_of_order(series) > few;
  return runs_on ? std::optional{widest} : std::nullopt;
}

}  // namespace

std::optional<ClockStep> clock_step(std::span<const Measurement> points) {
  std::map<std::tuple<int, int, PoseSet>, std::vector<Timed>> series;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Measurement& point = points[i];
    if (const auto time = measured_time(point.time))
      series[{point.station, point.smr, point.set}].push_back({i, time->seconds});
  }
  std::optional<ClockStep> first;
  for (const auto& [of, times] : series) {
    const auto step = step_of(times);
    if (step && (!first || step->after < first->after)) first = step;
  }
  return first;
}

}  // namespace truepose
