#include "proto/emscon/utf16.hpp"

#include "proto/text/utf8.hpp"

namespace truepose::emscon {
namespace {

bool is_high_surrogate(char16_t unit) { return (unit & 0xFC00) == 0xD800; }
bool is_low_surrogate(char16_t unit) { return (unit & 0xFC00) == 0xDC00; }

}  // namespace

std::string to_utf8(std::span<const char16_t> units) {
  std::string utf8;
  for (std::size_t i = 0; i < units.size() && units[i] != 0; ++i) {
    char32_t point = units[i];
    if (is_high_surrogate(units[i]) && i + 1 < units.size() && is_low_surrogate(units[i + 1])) {
      point = 0x10000 + ((point & 0x3FF) << 10) + (units[i + 1] & 0x3FFu);
      ++i;
    } else if (is_high_surrogate(units[i]) || is_low_surrogate(units[i])) {
      point = text::kReplacement;
    }
    text::append_utf8(utf8, point);
  }
  return utf8;
}

std::u16string to_utf16(std::string_view utf8) {
  std::u16string units;
  while (!utf8.empty()) {
    const char32_t point = text::take_code_point(utf8);
    if (point < 0x10000) {
      units += static_cast<char16_t>(point);
    } else {
      units += static_cast<char16_t>(0xD800 + ((point - 0x10000) >> 10));
      units += static_cast<char16_t>(0xDC00 + ((point - 0x10000) & 0x3FF));
    }
  }
  return units;
}

}  // namespace truepose::emscon
