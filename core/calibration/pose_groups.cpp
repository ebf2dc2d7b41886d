#include "core/calibration/pose_groups.hpp"

#include <algorithm>
#include <map>

namespace truepose {

std::vector<std::vector<std::size_t>> pose_groups(std::span<const Measurement> points) {
  const auto before = [](const JointVector& a, const JointVector& b) {
    return std::ranges::lexicographical_compare(a, b);
  };
  std::map<JointVector, std::size_t, decltype(before)> pose_of(before);
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto [pose, is_new] = pose_of.try_emplace(points[k].q, groups.size());
    if (is_new) groups.emplace_back();
    groups[pose->second].push_back(k);
  }
  return groups;
}

}  // namespace truepose
