#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/choices.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// An arm that was cold at the first point of each station, and warms up by an exponential.
struct WarmUpClock {
  bool by_order = false;  ///< in poses, one after the other; else in seconds
  double constant = 0;
};

/// Whether the points tell their time, and by a clock that did not stand.
bool has_times(std::span<const Measurement> points);

/// The points with how warm they were as the temperatures of all drives: from 0, cold, to 1, warm through.
/// Those that do not tell their time have none.
MeasurementData with_warmth_by(const WarmUpClock& clock, MeasurementData data);

/// The time constants that are tried: for the times of the points, or their order.
std::vector<WarmUpClock> warm_up_clocks(const MeasurementData& data);

/// Whether the warmth of the points is much of a function of their joints, or they are too few to tell: then
/// what the joints do and what warmth does look the same, as with rows that were sorted.
bool follows_the_joints(std::span<const Measurement> points);

}  // namespace truepose
