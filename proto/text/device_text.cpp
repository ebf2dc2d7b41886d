#include "proto/text/device_text.hpp"

#include <algorithm>
#include <limits>

#include "proto/text/utf8.hpp"

namespace truepose::text {
namespace {

bool is_line_break(char32_t point) { return point == '\t' || point == '\n' || point == '\r'; }

/// C0, DEL and C1: some terminals take U+009B for the beginning of a command, as they take ESC [.
bool is_control(char32_t point) { return point < 0x20 || (point >= 0x7F && point < 0xA0); }

char32_t cleaned(char32_t point, LineBreaks line_breaks) {
  if (is_line_break(point)) return line_breaks == LineBreaks::Kept ? point : ' ';
  return is_control(point) ? kReplacement : point;
}

std::string cleaned(std::string_view text, LineBreaks line_breaks, std::size_t characters) {
  std::string result;
  for (; !text.empty() && characters > 0; --characters)
    append_utf8(result, cleaned(take_code_point(text), line_breaks));
  return result;
}

}  // namespace

std::string clean_text(std::string_view text, LineBreaks line_breaks) {
  return cleaned(text, line_breaks, std::numeric_limits<std::size_t>::max());
}

std::string device_text(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  std::string result = cleaned(text, LineBreaks::Blank, kLongestDeviceText);
  result.erase(result.find_last_not_of(' ') + 1);
  return result;
}

}  // namespace truepose::text
