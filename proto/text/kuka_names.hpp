#pragma once

#include <array>
#include <string_view>

namespace truepose {

using SixNames = std::array<std::string_view, 6>;

/// What KRL, EKI and RSI alike call the axes, and the parts of a pose.
inline constexpr SixNames kAxisNames{"A1", "A2", "A3", "A4", "A5", "A6"};
inline constexpr SixNames kPoseNames{"X", "Y", "Z", "A", "B", "C"};

}  // namespace truepose
