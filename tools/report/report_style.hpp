#pragma once

#include <string_view>

namespace truepose::report {

// One colour per stage, told apart by colour-blind readers too (Okabe and Ito's palette), on paper by the
// marker's shape.
inline constexpr std::string_view kBeforeColor = "#d55e00";
inline constexpr std::string_view kGeometricColor = "#0072b2";
inline constexpr std::string_view kLayersColor = "#7b4fa3";
inline constexpr std::string_view kCompensatedColor = "#00805e";

/// The page's style sheet. Holds no '<' or '&', so that the page stays well-formed XML.
extern const std::string_view kStyleSheet;

}  // namespace truepose::report
