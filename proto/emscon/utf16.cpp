#include "proto/emscon/utf16.hpp"

namespace truepose::emscon {
namespace {

constexpr char32_t kReplacement = 0xFFFD;

bool is_high_surrogate(char16_t unit) { return (unit & 0xFC00) == 0xD800; }
bool is_low_surrogate(char16_t unit) { return (unit & 0xFC00) == 0xDC00; }

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

/// The code point at the front of `text`, which it is cut off from.
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

}  // namespace

std::string to_utf8(std::span<const char16_t> units) {
  std::string text;
  for (std::size_t i = 0; i < units.size() && units[i] != 0; ++i) {
    char32_t point = units[i];
    if (is_high_surrogate(units[i]) && i + 1 < units.size() && is_low_surrogate(units[i + 1])) {
      point = 0x10000 + ((point & 0x3FF) << 10) + (units[i + 1] & 0x3FFu);
      ++i;
    } else if (is_high_surrogate(units[i]) || is_low_surrogate(units[i])) {
      point = kReplacement;
    }
    append_utf8(text, point);
  }
  return text;
}

std::u16string to_utf16(std::string_view text) {
  std::u16string units;
  while (!text.empty()) {
    const char32_t point = take_code_point(text);
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
