#pragma once

#include <string>
#include <string_view>

namespace truepose::text {

/// Stands for what is not valid.
inline constexpr char32_t kReplacement = 0xFFFD;

/// The code point at the front of `text`, which it is cut off from; a byte that begins none is U+FFFD.
char32_t take_code_point(std::string_view& text);

void append_utf8(std::string& text, char32_t point);

}  // namespace truepose::text
