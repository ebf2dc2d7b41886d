#pragma once

namespace truepose {

/// The smallest error of a position that is reported: no tracker measures less.
inline constexpr double kLeastError_mm = 1e-3;
/// Errors of arms are millimetres. A larger deviation is of another arm, or a mistake in the files.
inline constexpr double kMaxArmError_mm = 50;

}  // namespace truepose
