#include "proto/text/utf8.hpp"

#include <array>
#include <cstddef>

namespace truepose::text {

void append_utf8(std::string& text, char32_t point) {
  const auto tail = [&](int shift) { text += static_cast<char>(0x80 | ((point >> shift) & 0x3F)); };
  if (point < 0x80) {
    text += static_cast<char>(point);
  } else if (point < 0x800) {
    text += static_cast<char>(0xC0 | (point >> 6));
    tail(0);
  } else if (point < 0x10000) {
    text += static_cast<char>(0xE0 | (point >> 12));
    tail(6);
    tail(0);
  } else {
    text += static_cast<char>(0xF0 | (point >> 18));
    tail(12);
    tail(6);
    tail(0);
  }
}

char32_t take_code_point(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<char32_t>(static_cast<unsigned char>(text[i])); };
  const char32_t lead = byte(0);
  const std::size_t tails = lead < 0x80   ? 0
                            : lead < 0xC2 ? 4
                            : lead < 0xE0 ? 1
                            : lead < 0xF0 ? 2
                            : lead < 0xF5 ? 3
                                          : 4;
  char32_t point = tails == 0 ? lead : lead & (0x3Fu >> tails);
  bool valid = tails < 4 && tails < text.size();
  for (std::size_t i = 1; valid && i <= tails; ++i) {
    valid = (byte(i) & 0xC0) == 0x80;
    point = point << 6 | (byte(i) & 0x3F);
  }
  constexpr std::array<char32_t, 4> kLeast{0, 0x80, 0x800, 0x10000};
  valid = valid && point >= kLeast[tails] && point <= 0x10FFFF && (point & ~char32_t{0x7FF}) != 0xD800;
  text.remove_prefix(valid ? tails + 1 : 1);
  return valid ? point : kReplacement;
}

}  // namespace truepose::text
