#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "core/data/measurement.hpp"

namespace truepose {

/// A clock that was set back while points were measured, as by summer time's end or a time server.
struct ClockStep {
  std::size_t before = 0, after = 0;  ///< the points between which it was
  double back_s = 0;
};

/// Where the times of the points, as they stand, go back and run on from there: the first such place of the
/// points of one station, reflector and set. Nothing where rows do not stand in the order of their times at
/// all, or where some were only measured again.
std::optional<ClockStep> clock_step(std::span<const Measurement> points);

}  // namespace truepose
