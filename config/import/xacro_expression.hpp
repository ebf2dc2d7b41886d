#pragma once

#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace truepose::config {

/// A value of xacro: a number (true and false are 1 and 0) or a text.
using XacroValue = std::variant<double, std::string>;

/// As it is written into an attribute, with the digits that bring a number back.
std::string xacro_text(const XacroValue& value);

/// A text that is a number as a whole becomes one.
XacroValue xacro_value(const std::string& text);

/// Evaluates what stands between ${ and }: numbers, texts in quotes, names, + - * / % **, comparisons, and,
/// or, not, `a if b else c`, pi, and the functions radians, degrees, sin, cos, tan, asin, acos, atan, atan2,
/// sqrt, abs, min, max, float, int, str.
///
/// @param value_of  of a name, nothing where it is not defined
/// @return the value, or one phrase that says what is not understood
std::expected<XacroValue, std::string> evaluate_xacro(
    std::string_view expression,
    const std::function<std::optional<XacroValue>(const std::string&)>& value_of);

}  // namespace truepose::config
