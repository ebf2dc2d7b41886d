#pragma once

#include <numbers>

namespace truepose {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kMetresPerMm = 1e-3;

}  // namespace truepose
