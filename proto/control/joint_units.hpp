#pragma once

#include "core/kinematics/angles.hpp"
#include "core/kinematics/robot_model.hpp"

namespace truepose::control {

/// What operators read of one joint: deg, mm for a prismatic joint.
inline double operator_units(const Joint& joint, double q) {
  return joint.type == JointType::Revolute ? q * kDegPerRad : q;
}

}  // namespace truepose::control
