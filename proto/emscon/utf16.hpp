#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace truepose::emscon {

/// UTF-16 up to the first zero, as UTF-8. A lone surrogate becomes U+FFFD.
std::string to_utf8(std::span<const char16_t> units);

/// UTF-8 as UTF-16; malformed bytes become U+FFFD.
std::u16string to_utf16(std::string_view utf8);

/// The same cut to N units (never inside a surrogate pair) and filled with zeros.
template <std::size_t N>
std::array<char16_t, N> to_utf16(std::string_view text) {
  const std::u16string units = to_utf16(text);
  std::size_t size = std::min(N, units.size());
  if (size < units.size() && size > 0 && (units[size - 1] & 0xFC00) == 0xD800) --size;
  std::array<char16_t, N> filled{};
  std::copy_n(units.begin(), size, filled.begin());
  return filled;
}

}  // namespace truepose::emscon
