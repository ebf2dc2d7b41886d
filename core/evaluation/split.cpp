#include "core/evaluation/split.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/random.hpp"

namespace truepose {

void split_poses(MeasurementData& data, double fraction, std::uint64_t seed) {
  const std::vector<int> pose_of_point = pose_numbers(data.points);
  std::vector<std::size_t> shuffled(static_cast<std::size_t>(count_poses(data.points)));
  std::iota(shuffled.begin(), shuffled.end(), std::size_t{0});
  Random random(seed);
  for (std::size_t i = shuffled.size(); i-- > 1;) std::swap(shuffled[i], shuffled[random.next() % (i + 1)]);

  const auto identify =
      static_cast<std::size_t>(std::llround(fraction * static_cast<double>(shuffled.size())));
  std::vector<PoseSet> set_of_pose(shuffled.size(), PoseSet::Validate);
  for (std::size_t i = 0; i < std::min(identify, shuffled.size()); ++i)
    set_of_pose[shuffled[i]] = PoseSet::Identify;
  for (std::size_t i = 0; i < data.points.size(); ++i)
    data.points[i].set = set_of_pose[static_cast<std::size_t>(pose_of_point[i])];
}

}  // namespace truepose
