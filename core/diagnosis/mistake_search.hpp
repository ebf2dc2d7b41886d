#pragma once

#include <vector>

#include "core/diagnosis/diagnosis.hpp"

namespace truepose {

/// The mistakes that show with base and reflectors alone, by construction: units first, of which the
/// magnitudes say which are in doubt, then each mistake alone. Where none explains the points, the next one
/// is sought given the most promising fixes so far; at last one together with rows in any order.
///
/// @return as Diagnosis::explaining(): units, and up to two mistakes besides
std::vector<Hypothesis> gross_mistakes(const Diagnosis& diagnosis, const RobotModel& nominal,
                                       const MeasurementData& data, int jobs);

}  // namespace truepose
