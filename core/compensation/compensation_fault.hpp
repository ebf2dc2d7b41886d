#pragma once

#include <string>

#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// Why a target is not reached.
struct CompensationFault {
  enum class Kind { DidNotConverge, NotFinite, BeyondLimit, TooFar };
  Kind kind = Kind::DidNotConverge;
  int joint = 0;         ///< BeyondLimit, TooFar: its index
  double q_wrong = 0;    ///< BeyondLimit: where it would have to go, rad or mm
  double too_large = 0;  ///< TooFar: the correction that it would need, rad or mm
};

/// "joint 4 would have to go to 352.1 deg, its limits are -350..350"
/// @param nominal  whose limits they are
std::string described(const CompensationFault& fault, const RobotModel& nominal);

}  // namespace truepose
