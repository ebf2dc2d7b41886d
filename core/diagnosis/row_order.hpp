#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// Joints that stand beside another row's points: all rows shifted by a few against each other, or from one
/// in the middle on, where a point or a joint position is missing.
///
/// They need every row in the file's order. Where the gap is is found with the arm of the case, so a mistake
/// of the arm is mended before.
std::vector<Mistake> row_order_mistakes(std::span<const std::string> smr_names);

/// Rows in any other order, as far as joints and points agree as sets.
Mistake unordered_rows(std::span<const std::string> smr_names);

}  // namespace truepose
