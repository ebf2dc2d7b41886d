#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>

namespace truepose::text {

/// Bytes that may be looked at behind a text whose numbers are read.
inline constexpr std::size_t kDecimalPadding = 8;

/// A decimal number, digits with a point among them or without, as std::from_chars reads it, but faster where
/// there are up to seven on either side: they and their power of ten are whole numbers that a double holds
/// exactly, so that one division is rounded right. A plus sign, exponents and points at an end are left to
/// others.
/// @return behind the number, null where none stands there
const char* read_decimal(const char* at, double& value) noexcept;

/// Digits alone, at most 18.
/// @return behind the number, null where none stands there
const char* read_whole(const char* at, std::int64_t& value) noexcept;

/// As std::to_chars writes it with std::chars_format::fixed, but faster: where what is left out leaves no
/// doubt of the last digit.
std::to_chars_result write_fixed(char* first, char* last, double value, int decimals) noexcept;

}  // namespace truepose::text
