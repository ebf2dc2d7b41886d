#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// Joints in the row of another point: all rows are shifted by a few, or the rows after one where a point or
/// a joint position is missing.
///
/// They need every row in the file's order. The gap is located with the arm of the hypothesis, so a mistake
/// of the arm is fixed before.
std::vector<Mistake> row_order_mistakes(std::span<const std::string> smr_names);

/// Rows in any other order, as far as joints and points agree as sets.
Mistake unordered_rows(std::span<const std::string> smr_names);

}  // namespace truepose
