#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/quality/calibration_verdict.hpp"

namespace truepose {

/// One of several splits of the same points, and the calibration that came of it.
struct JudgedSplit {
  std::uint64_t seed = 0;
  CalibrationVerdict verdict;  ///< by no tolerance
  double largest_mm = 0;       ///< error of those points that validated
};

/// The one verdict on a calibration that was validated by several splits. It has
/// - the findings on the first, whose model is kept,
/// - an error where a position error of any split is beyond the tolerance,
/// - an error where another split than the first is refused, and
/// - what other splits than the first warn of: a warning where more than half of all do, else a note.
///
/// A doubt that chance raises on a sound campaign in one of 200 splits is raised in more than half of them
/// less often than one in 100 times, with any number of splits (Markov): more splits find more, and do not
/// doubt more.
///
/// @param splits  at least one
CalibrationVerdict verdict_over_splits(std::span<const JudgedSplit> splits,
                                       std::optional<double> tolerance_mm);

}  // namespace truepose
