#pragma once

#include <span>

#include "core/data/calibrated_cell.hpp"

namespace truepose {

/// The largest correction of a joint (rad; of a slide, as many metres) that makes a calibrated arm stand
/// where the nominal one would at these poses, its first reflector first. Where a pose is refused: the most
/// that compensation allows. A function of the arms and the poses alone, so that it can be judged again years
/// later.
double largest_correction(const RobotModel& nominal, const CalibratedCell& calibrated,
                          std::span<const JointVector> poses);

}  // namespace truepose
