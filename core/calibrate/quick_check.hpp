#pragma once

#include "core/calibrate/identification.hpp"

namespace truepose {

/// Whether a plain fit of the geometry meets all points so well that diagnose_files() and find_outliers(),
/// which fit many times, would find nothing: no link is off by more than arms are, next to nothing is left in
/// the middle, and every point is where the others say.
///
/// Doubtful cases are none: too many parameters for the points, more scatter than the middle of the points
/// shows, a point beyond five standard deviations.
bool passes_quick_check(const Identification& id);

}  // namespace truepose
