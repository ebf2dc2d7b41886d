#include "core/plan/orientation_choice.hpp"

#include <algorithm>
#include <limits>

#include "core/arm/forward.hpp"

namespace truepose {

std::vector<std::size_t> most_different_orientations(const RobotModel& robot,
                                                     std::span<const JointVector> candidates,
                                                     std::size_t count) {
  std::vector<Eigen::Matrix3d> turns;
  for (const JointVector& q : candidates) turns.push_back(forward_kinematics(robot, q).linear());
  // The squared distance of two rotation matrices grows with the angle between them.
  std::vector<double> nearest(turns.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> chosen{0};
  while (chosen.size() < count) {
    const Eigen::Matrix3d& last = turns[chosen.back()];
    for (std::size_t k = 0; k < turns.size(); ++k)
      nearest[k] = std::min(nearest[k], (turns[k] - last).squaredNorm());
    chosen.push_back(static_cast<std::size_t>(std::ranges::max_element(nearest) - nearest.begin()));
  }
  return chosen;
}

}  // namespace truepose
