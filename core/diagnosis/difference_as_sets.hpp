#pragma once

#include <cstddef>
#include <span>

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// By how much the points differ from those that the arm reaches, whatever the order of the rows and wherever
/// the arm stands: the median difference, in mm, of their distances from their mean, both sorted, with the
/// reflectors at the flange where it is least.
///
/// Neither order nor placement changes these distances, so that the right one of several arms is found
/// without either: there, its own errors alone are left. A wrong arm may come as near by chance.
///
/// @param reflectors  so many do the rows name
/// @param rows        the joints of each belong to the points of any
double difference_as_sets(const RobotModel& arm, std::size_t reflectors, std::span<const Measurement> rows);

}  // namespace truepose
