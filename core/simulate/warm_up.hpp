#pragma once

#include "core/arm/robot_model.hpp"
#include "core/simulate/joint_motion.hpp"

namespace truepose {

/// What becomes of an arm as its drives warm up: all of it comes by the same exponential.
struct WarmUp {
  JointVector zero;   ///< by which each joint's zero moves (rad, mm, in the sense of q); empty: none
  double growth = 0;  ///< share by which all lengths grow: 12e-6 of steel for each kelvin
  Seconds time_constant{1800};
};

/// The arm so long after it was switched on cold.
RobotModel warmed(RobotModel cold, const WarmUp& warm_up, Seconds since_start);

}  // namespace truepose
