#include "core/calibration/measurement.hpp"

#include <algorithm>
#include <iterator>
#include <map>

namespace truepose {

std::vector<int> pose_numbers(std::span<const Measurement> points) {
  const auto before = [](const JointVector* a, const JointVector* b) {
    return std::ranges::lexicographical_compare(*a, *b);
  };
  std::map<const JointVector*, int, decltype(before)> number_of(before);
  std::vector<int> numbers;
  numbers.reserve(points.size());
  for (const Measurement& point : points) {
    const int next = static_cast<int>(number_of.size());
    numbers.push_back(number_of.emplace(&point.q, next).first->second);
  }
  return numbers;
}

std::vector<std::vector<std::size_t>> pose_groups(std::span<const Measurement> points) {
  const std::vector<int> numbers = pose_numbers(points);
  std::vector<std::vector<std::size_t>> groups(static_cast<std::size_t>(count_poses(points)));
  for (std::size_t i = 0; i < points.size(); ++i) groups[static_cast<std::size_t>(numbers[i])].push_back(i);
  return groups;
}

int count_poses(std::span<const Measurement> points) {
  const std::vector<int> numbers = pose_numbers(points);
  return numbers.empty() ? 0 : *std::ranges::max_element(numbers) + 1;
}

std::vector<Measurement> points_of(const MeasurementData& data, PoseSet set) {
  std::vector<Measurement> points;
  std::ranges::copy_if(data.points, std::back_inserter(points),
                       [set](const Measurement& m) { return m.set == set; });
  return points;
}

}  // namespace truepose
