#pragma once

#include <array>
#include <utility>

namespace truepose {

inline constexpr double kMmPerInch = 25.4;
inline constexpr double kMmPerMetre = 1000;

/// In what lengths stand that are taken as mm, and how many mm one of it is.
inline constexpr std::array kOtherUnits{std::pair{"m", kMmPerMetre}, std::pair{"inches", kMmPerInch}};

}  // namespace truepose
