#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"
#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// The probable cause of a large error: a mistake in the robot file or the measurements. Each candidate is
/// tried against the points.
struct ProbableCause {
  double error_mm = 0;            ///< median miss of the points with base and reflectors fitted
  double fixed_mm = 0;            ///< the same without the mistake; error_mm where none was found
  std::string sentence;           ///< for the operator, with both errors
  std::vector<Mistake> mistakes;  ///< of the sentence, and where they are; none: nothing explains it
  int station = 0;                ///< index of the one that the points are from
  RobotModel fixed_arm;           ///< without them
  std::vector<Measurement> fixed_points;
  std::vector<ProbableCause> others;  ///< other mistakes that explain the points as well
};

/// The sentence, and what else it may be.
std::string in_words(const ProbableCause& cause);

/// Distinguishes wrong files from an arm that merely deviates.
///
/// Magnitudes of joints, points, lengths and angles decide on units first: where they show others than mm and
/// deg, the converted files are looked at, and their units are named with what else is wrong with them.
///
/// Where base and reflectors alone leave more than 5 mm and no usual deviations of the links explain it,
/// gross_mistakes() seeks them: units by magnitude, mistakes alone, then one more given the fixes found;
/// where the identified arm leaves more than a tracker does, those that hardly show before: a sign, a zero or
/// rows out of step, with a reflector near an axis or poses along a path. A mistake is reported only if
/// Diagnosis::explaining() returns it. Without one, an arm with an error above 50 mm is refused. A mistake
/// that no pose shows, as the sign of an axis right through the only reflector, is not found and does no
/// harm. Lengths and points both in metres fit each other: such an arm is detected by its tiny reach.
///
/// @param data  points that calibrate() accepts; all sets are used
/// @param jobs  threads; the result is the same with any number
/// @return the best explanation; nothing where nothing is wrong, or fewer than eight poses cannot tell
std::optional<ProbableCause> diagnose_files(const RobotModel& nominal, const MeasurementData& data,
                                            int jobs = 1);

}  // namespace truepose
