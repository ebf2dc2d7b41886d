#pragma once

#include <optional>
#include <string>

#include "drivers/tracker.hpp"

namespace truepose::drivers {

/// Why a point cannot be what a tracker measured, in one sentence with the value and what is plausible: its
/// spread, or the air by which it corrected its distances (1 K or 3.6 mbar are 1 um/m).
std::optional<std::string> implausible(const SmrPoint& point);

}  // namespace truepose::drivers
