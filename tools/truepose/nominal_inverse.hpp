#pragma once

#include <expected>
#include <optional>
#include <string>

#include "core/kinematics/spherical_wrist.hpp"

namespace truepose::tools {

/// Joint positions of the nominal arm at one pose after the other, each on the branch nearest to the pose
/// before it.
class NominalInverse {
 public:
  explicit NominalInverse(const RobotModel& robot);

  /// @return joint positions within the limits, or why there are none
  std::expected<JointVector, std::string> next(const Eigen::Isometry3d& X_BF);

 private:
  std::expected<JointVector, std::string> by_newton(const Eigen::Isometry3d& X_BF) const;

  RobotModel robot_;
  std::optional<SphericalWristInverse> closed_form_;
  JointVector q_near_;  // at first the middle of the joints' ranges
};

}  // namespace truepose::tools
