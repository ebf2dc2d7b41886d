#pragma once

#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/math/random.hpp"

/// Poses as a robot's own work has them: along a path, the flange hardly turned.
namespace truepose::example {

enum class Path { Line, Circle, Plane, Grid, Spline };
inline constexpr Path kPaths[] = {Path::Line, Path::Circle, Path::Plane, Path::Grid, Path::Spline};
const char* name_of(Path path);

/// Poses spread over a path of some decimetres somewhere within reach.
///
/// @param turn_rad  the flange turns by up to this about all axes; an arm of less than six joints about the
///                  base's z alone
std::vector<JointVector> along(const RobotModel& robot, Path path, int poses, double turn_rad,
                               Random& random);

}  // namespace truepose::example
