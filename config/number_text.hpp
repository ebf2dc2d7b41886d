#pragma once

#include <expected>
#include <string>
#include <string_view>

namespace truepose::config {

/// A finite decimal number that fills the whole text. Hexadecimal, leading zeros ("010", octal to some
/// readers), inf and nan are refused, so that a number means to every program what it means to the eye.
/// @return the number, or one phrase: "not a number: 'abc'"
std::expected<double, std::string> parse_number(std::string_view text);

/// The shortest decimal text that reads back as exactly this number.
std::string format_number(double value);

/// `text` in single quotes for a message: cut where it is long, control characters as '?'.
std::string in_quotes(std::string_view text);

}  // namespace truepose::config
