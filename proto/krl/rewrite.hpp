#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/krl/position.hpp"

namespace truepose::krl {

/// New text for the bytes [begin, end).
struct Edit {
  std::size_t begin = 0, end = 0;
  std::string text;
};

/// The text with its edits; everything else stays as it is, byte for byte.
/// @param edits  in any order, none overlapping another
std::string rewritten(std::string_view text, std::vector<Edit> edits);

/// A number as KRL writes it, with at most nine decimals, of which trailing zeros but the first are left out.
/// Nine decimals of a degree are 1e-7 mm at the end of a long arm, far below what a REAL of the controller
/// holds, so that the text itself never limits a simulation with better numbers.
std::string number_text(double value);

/// Whether a number would be written as another one than its text is.
bool is_changed(const Number& number, double value);

}  // namespace truepose::krl
