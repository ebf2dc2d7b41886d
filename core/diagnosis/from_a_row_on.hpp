#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// What may be wrong with the points from a row on, or up to one: another unit, another set-up of the
/// tracker.
std::vector<Mistake> mistakes_from_a_row_on(std::span<const std::string> smr_names);

}  // namespace truepose
