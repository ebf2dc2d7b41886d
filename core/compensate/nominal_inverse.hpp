#pragma once

#include <expected>
#include <optional>
#include <string>

#include "core/arm/spherical_wrist.hpp"
#include "core/arm/status_turn.hpp"
#include "core/compensate/target_compensation.hpp"

namespace truepose {

/// Joint positions of the nominal arm at one target after the other, each on the branch nearest to the target
/// before it.
class NominalInverse {
 public:
  using Result = std::expected<JointVector, std::string>;

  /// @param q_near  what the first target is near to; where not given, the middle of the joints' ranges
  NominalInverse(const RobotModel& robot, const std::optional<JointVector>& q_near);

  // Each gives joint positions within the limits, or says why there are none.

  Result at_pose(const Eigen::Isometry3d& X_BF);
  /// @param status, turn  KUKA's; without turn, the nearest of its turns
  Result at_pose(const Eigen::Isometry3d& X_BF, std::optional<int> status, std::optional<int> turn);
  /// p_F is at p_B, the orientation by the smallest change of the joints.
  Result at_position(const Eigen::Vector3d& p_B_mm, const Eigen::Vector3d& p_F_mm);

 private:
  template <typename Solve>
  Result from_several_starts(Solve solve) const;
  Result remembered(Result q);

  RobotModel robot_;
  TargetCompensation itself_;
  std::optional<SphericalWristInverse> closed_form_;
  std::expected<StatusTurnInverse, std::string> by_status_;
  JointVector q_near_;
};

}  // namespace truepose
