#pragma once

#include <span>

#include "drivers/tracker.hpp"

namespace truepose::daemon {

/// The mean of readings of one place that know nothing of each other, at least one: of n its scatter is
/// 1/sqrt(n) of the root mean square of theirs, and its air the mean of theirs.
drivers::SmrPoint mean_reading(std::span<const drivers::SmrPoint> readings);

}  // namespace truepose::daemon
