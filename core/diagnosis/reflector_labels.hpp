#pragma once

#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Points whose reflectors are named alike in all poses.
struct Relabelled {
  std::vector<Measurement> points;  ///< as given, but for `smr`
  std::vector<int> rows;            ///< first row of each pose whose names were changed
};

/// Finds poses in which the names of the reflectors are mixed up.
///
/// The middle of a pose's points does not depend on their names, so base and middle are fitted first. Turned
/// back into the flange frame with them, the points of each pose are matched with those of the poses before.
/// The names that most poses agree on stay. Poses that do not show every reflector are left as they are.
///
/// @param points  five reflectors at most; with one, nothing is changed
Relabelled relabelled(const RobotModel& arm, std::span<const std::string> smr_names,
                      std::span<const Measurement> points);

}  // namespace truepose
