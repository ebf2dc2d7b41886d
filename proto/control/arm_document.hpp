#pragma once

#include <boost/json/fwd.hpp>

#include "core/arm/robot_model.hpp"

namespace truepose::control {

/// The geometry, limits and masses of an arm as a robot file says them (mm, deg, deg/s, kg), with the same
/// keys. JSON being YAML too, its text is a robot file. A payload is part of the last link's mass.
boost::json::object arm_document(const RobotModel& robot);

/// Joint positions, deg (mm for a prismatic joint).
boost::json::array joints_json(const JointVector& q, const RobotModel& robot);

}  // namespace truepose::control
