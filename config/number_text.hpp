#pragma once

#include <cstdint>
#include <expected>
#include <span>
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

/// ", renamed to 'x'" for an old name; ", did you mean 'x'?" for the known name nearest to a misspelt one;
/// nothing where none is near.
std::string suggestion(std::string_view misspelt, std::span<const std::string> known);

struct Endpoint {
  std::string host;
  std::uint16_t port = 0;
};

/// Reads HOST:PORT, an IPv6 address in brackets.
/// @param least_port  1 for a peer; 0 for a socket of ours, which may take any free one
/// @return what was expected and found, where it is not that
std::expected<Endpoint, std::string> parse_endpoint(std::string_view text, std::uint16_t least_port = 1);

/// HOST:PORT, which parse_endpoint() reads back.
std::string text(const Endpoint& endpoint);

}  // namespace truepose::config
