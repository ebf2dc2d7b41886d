#pragma once

#include <string>

namespace truepose::config {

/// Text of a file that another program wrote.
struct DecodedText {
  std::string text;  ///< UTF-8 without a byte order mark; typographic blanks and minus signs as plain ones
  std::string encoding;  ///< that it was in: "UTF-16", "Windows-1252"; empty: UTF-8
};

/// Decodes UTF-8, UTF-16 (by its byte order mark, or by where the zero bytes of its ASCII characters are)
/// and, as what is none of these, Windows-1252, which Latin-1 is a part of.
///
/// @param file  stands in the messages
/// Throws ConfigError for a workbook, an archive and other files that are no text.
DecodedText decode_text(std::string bytes, const std::string& file);

}  // namespace truepose::config
