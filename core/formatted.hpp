#pragma once

#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <string>

namespace truepose {

/// A sentence with numbers in it, as printf says them.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
  va_list values, counted;
  va_start(values, format);
  va_copy(counted, values);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, counted)), '\0');
  va_end(counted);
  std::vsnprintf(text.data(), text.size() + 1, format, values);
  va_end(values);
  return text;
}

}  // namespace truepose
