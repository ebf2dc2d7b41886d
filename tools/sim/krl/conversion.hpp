#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace truepose::sim::krl {

/// %[width][.digits]letter in a format of SWRITE and SREAD.
struct Conversion {
  static constexpr int kWidest = 250;

  int width = 0;
  std::optional<int> digits;
  char letter = '\0';
};

/// @param at  behind %; then behind the conversion
Conversion read_conversion(const std::string& format, std::size_t& at);

}  // namespace truepose::sim::krl
