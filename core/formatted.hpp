#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace truepose {

/// A sentence with numbers in it, as printf says them; cut at 399 characters.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
  char text[400];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

}  // namespace truepose
