#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/identify/measurement.hpp"

namespace truepose {

/// A mistake in the robot file or the measurements, found by trying which one explains the points.
struct Suspicion {
  double error_mm = 0;                 ///< median miss of the points with base and reflectors fitted
  double mended_mm = 0;                ///< the same without the mistake; error_mm where none was found
  std::string sentence;                ///< for the operator, with both errors
  std::vector<std::string> also_fits;  ///< other mistakes that explain the points as well
};

/// Tells a nominal arm that cannot be right (a sign, a zero, an alpha, a and d, joint columns, units) from
/// one that merely deviates.
///
/// The arm is suspected where base and reflectors alone leave more than 5 mm and mending one mistake halves
/// it (several: leaves a fifth); where the identified arm is better by a third with the sign of a joint
/// changed that hardly shows before (a reflector near an axis); or where more than 50 mm are left, whatever
/// explains them. No mistake makes an arm that merely deviates so much better, even with three times the
/// paper's errors. A mistake that no pose shows, as the sign of an axis right through the only reflector, is
/// not found and does no harm.
///
/// @param data  points that calibrate() accepts; all sets are used, at most 150 poses of them
/// @return the best explanation; nothing where nothing is wrong, or fewer than eight poses cannot tell
std::optional<Suspicion> suspect(const RobotModel& nominal, const MeasurementData& data);

}  // namespace truepose
