#include "core/fit/measured_order.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "core/data/measured_time.hpp"
#include "core/fit/measurement_model.hpp"

namespace truepose {
namespace {

/// Times in seconds, where all points tell them.
std::optional<std::vector<double>> times_of(std::span<const Measurement> points) {
  std::vector<double> seconds;
  for (const Measurement& point : points) {
    const auto time = measured_time(point.time);
    if (!time) return std::nullopt;
    seconds.push_back(time->seconds);
  }
  return seconds;
}

/// Whether some pose was measured with a reflector more than once.
bool comes_back(std::span<const Measurement> points, std::span<const int> pose,
                std::span<const std::size_t> order) {
  std::set<std::tuple<int, int, int>> seen;
  return std::ranges::any_of(order, [&](std::size_t i) {
    return !seen.insert({pose[i], points[i].smr, points[i].station}).second;
  });
}

}  // namespace

std::vector<std::size_t> measured_order(std::span<const Measurement> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::vector<int> pose = pose_numbers(points);
  if (const auto seconds = times_of(points)) {
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return (*seconds)[i]; });
    return order;
  }
  std::erase_if(order, [&](std::size_t i) { return !points[i].in_order; });
  if (!comes_back(points, pose, order))
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return pose[i]; });
  return order;
}

std::vector<std::vector<std::size_t>> stops_of(std::span<const Measurement> points) {
  const std::vector<int> pose = pose_numbers(points);
  std::vector<std::vector<std::size_t>> stops;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto is_of_it = [&](std::size_t other) {
      return pose[other] == pose[i] && points[other].station == points[i].station &&
             points[other].smr != points[i].smr;
    };
    if (stops.empty() || !std::ranges::all_of(stops.back(), is_of_it)) stops.emplace_back();
    stops.back().push_back(i);
  }
  return stops;
}

double points_per_stop(std::span<const Measurement> points) {
  return static_cast<double>(points.size()) / static_cast<double>(stops_of(points).size());
}

}  // namespace truepose
