#pragma once

namespace truepose {

/// An error of a position below which there is nothing to tell: less than that nobody measures.
inline constexpr double kLeastError_mm = 1e-3;
/// Arms are wrong by millimetres: what is farther off is of something else, or told wrongly.
inline constexpr double kFarthestError_mm = 50;

}  // namespace truepose
