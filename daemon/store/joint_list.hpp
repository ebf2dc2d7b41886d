#pragma once

#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::daemon {

// Lists of numbers are kept as JSON text with every digit: a person can read them, json_each() too.

template <typename Numbers>
std::string list_text(const Numbers& numbers) {
  std::string text = "[";
  for (const auto value : numbers) {
    if (text.size() > 1) text += ',';
    std::array<char, 32> digits;
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text.append(digits.data(), end);
  }
  return text + "]";
}

/// @return nothing where the text is no list of numbers
std::optional<std::vector<double>> numbers_of(std::string_view text);

/// @return nothing where the text is no list of numbers, or of more than kMaxJoints
std::optional<JointVector> joints_of(std::string_view text);

}  // namespace truepose::daemon
