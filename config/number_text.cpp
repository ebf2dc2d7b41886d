#include "config/number_text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace truepose::config {

namespace {

bool has_leading_zero(std::string_view digits) {
  return digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9';
}

}  // namespace

std::expected<double, std::string> parse_number(std::string_view text) {
  std::string_view number = text;
  if (number.starts_with('+') && !number.starts_with("+-")) number.remove_prefix(1);
  const std::string_view digits = number.starts_with('-') ? number.substr(1) : number;
  if (has_leading_zero(digits)) return std::unexpected("a number with a leading zero: " + in_quotes(text));

  double value = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (end != number.data() + number.size() || error == std::errc::invalid_argument) {
    return std::unexpected("not a number: " + in_quotes(text));
  }
  if (error == std::errc::result_out_of_range)
    return std::unexpected("a number out of range: " + in_quotes(text));
  if (!std::isfinite(value)) return std::unexpected("not a finite number: " + in_quotes(text));
  return value;
}

std::string format_number(double value) {
  std::array<char, 32> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) result += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  result += text.size() > kLongest ? "...'" : "'";
  return result;
}

}  // namespace truepose::config
