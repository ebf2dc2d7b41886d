#pragma once

#include <limits>

#include "config/yaml_reader.hpp"

/// Bounds that keep out what no arm and no cell can be: a slip of unit or of a digit.
namespace truepose::config {

inline constexpr Range kMm{-100'000, 100'000};
inline constexpr Range kDeg{-360, 360};
inline constexpr Range kRad{-1e4, 1e4};
inline constexpr Range kKg{0, 100'000};
inline constexpr Range kAny{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};

}  // namespace truepose::config
