#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// What is left of a calibrated arm's error once its parameters are known: a small displacement of the
/// flange for every joint position. Used by the real-time cycle: does not allocate, throw or lock.
class ResidualField {
 public:
  virtual ~ResidualField() = default;

  /// Where the flange truly is.
  ///
  /// @param q     encoder positions
  /// @param X_BF  where the parameters put it
  virtual Eigen::Isometry3d displaced(const JointVector& q, const Eigen::Isometry3d& X_BF) const noexcept = 0;
};

}  // namespace truepose
