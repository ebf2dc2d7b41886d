#include "core/evaluation/split.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/random.hpp"

namespace truepose {
namespace {

/// The numbers of the poses, shuffled.
std::vector<std::size_t> shuffled_poses(int poses, std::uint64_t seed) {
  std::vector<std::size_t> shuffled(static_cast<std::size_t>(poses));
  std::iota(shuffled.begin(), shuffled.end(), std::size_t{0});
  Random random(seed);
  for (std::size_t i = shuffled.size(); i-- > 1;) std::swap(shuffled[i], shuffled[random.next() % (i + 1)]);
  return shuffled;
}

/// Marks every point by its pose: `set_of` gives the set of the pose at a place of the shuffled order.
template <typename SetOf>
void mark_poses(MeasurementData& data, std::uint64_t seed, SetOf set_of) {
  const std::vector<int> pose_of_point = pose_numbers(data.points);
  const std::vector<std::size_t> shuffled = shuffled_poses(count_poses(data.points), seed);
  std::vector<PoseSet> set_of_pose(shuffled.size());
  for (std::size_t place = 0; place < shuffled.size(); ++place) set_of_pose[shuffled[place]] = set_of(place);
  for (std::size_t i = 0; i < data.points.size(); ++i)
    data.points[i].set = set_of_pose[static_cast<std::size_t>(pose_of_point[i])];
}

}  // namespace

void split_poses(MeasurementData& data, double fraction, std::uint64_t seed) {
  const auto identify = static_cast<std::size_t>(std::llround(fraction * count_poses(data.points)));
  mark_poses(data, seed,
             [=](std::size_t place) { return place < identify ? PoseSet::Identify : PoseSet::Validate; });
}

void hold_out_fold(MeasurementData& data, int folds, int fold, std::uint64_t seed) {
  assert(folds >= 2 && fold >= 0 && fold < folds);
  mark_poses(data, seed, [=](std::size_t place) {
    const bool held_out = place % static_cast<std::size_t>(folds) == static_cast<std::size_t>(fold);
    return held_out ? PoseSet::Validate : PoseSet::Identify;
  });
}

}  // namespace truepose
