#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace truepose::text {

enum class LineBreaks {
  Blank,  ///< a tab and an end of line become a blank: the text stays one line of a log
  Kept,   ///< of a document
};

/// A text that may be logged, printed, stored and put into JSON, whatever was in it: valid UTF-8 without
/// control characters. What is not, becomes U+FFFD.
std::string clean_text(std::string_view text, LineBreaks line_breaks);

inline constexpr std::size_t kLongestDeviceText = 200;  ///< characters

/// What a device says of itself or of an error, cleaned, without blanks around it and cut at
/// kLongestDeviceText. Every text of a device passes here where it enters.
std::string device_text(std::string_view text);

}  // namespace truepose::text
