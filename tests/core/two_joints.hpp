#pragma once

#include "core/arm/robot_model.hpp"

namespace truepose {

inline JointVector two_joints(double first, double second) { return JointVector{{first, second}}; }

}  // namespace truepose
