#pragma once

#include <span>
#include <string>

#include "core/calibrate/calibration.hpp"

namespace truepose::config {

/// The identified parameters as CSV: name,unit,nominal,value,deviation,sigma,identified,data_share, every
/// number with the digits that bring it back exactly. Empty fields: nominal and deviation of what has no data
/// sheet (base, reflectors, deviations of joints), and sigma of what was not identified.
///
/// @param robot  the calibrated arm, whose deviations say their units
std::string parameter_csv(std::span<const IdentifiedParameter> parameters, const RobotModel& robot);

/// The arm as URDF (m, rad): base_link, link_1 .. link_N and flange, joined by joint_1 .. joint_N and the
/// fixed joint_flange. Kinematics alone: no masses or shapes, and a
/// comment says so where joints deviate or a residual field is left out. Its joints are those of the chain of
/// links, and the comment says what they take where the controller's are coupled. The frames are
/// forward_kinematics()'s, and each number has the digits that bring it back exactly.
std::string urdf(const RobotModel& calibrated);

/// What of a calibrated KUKA a controller itself can take, as CSV:
/// row,parameter,unit,nominal,value,change,where. where names the controller's own number (the arm's
/// $machine.dat, the zero of an axis), or says that there is none: tilts of axes and everything beyond
/// geometry need corrected positions. Angles in deg. Rows of parameters that were not identified or did not
/// change are left out.
///
/// @param robot  the calibrated arm: its rows say whether the numbers of $machine.dat are theirs
std::string kuka_corrections_csv(std::span<const IdentifiedParameter> parameters, const RobotModel& robot);

}  // namespace truepose::config
