#include "config/number_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <system_error>
#include <utility>
#include <vector>

#include "proto/text/host_port.hpp"
#include "proto/text/renamed.hpp"

namespace truepose::config {

namespace {

bool has_leading_zero(std::string_view digits) {
  return digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9';
}

// Optimal string alignment: letters put in, left out, changed, or two neighbours swapped.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row.back();
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

std::string suggestion(std::string_view misspelt, std::span<const std::string> known) {
  if (std::string renaming = renamed(misspelt, known); !renaming.empty()) return renaming;
  constexpr std::size_t kLongest =
      64;  // a longer name is no slip of the finger, and the distance costs its square
  if (misspelt.size() > kLongest) return {};
  const std::string* nearest = nullptr;
  std::size_t best = std::max<std::size_t>(1, misspelt.size() / 3) + 1;
  for (const std::string& name : known) {
    // The unit is what is left out most: "ramp" for "ramp_ms".
    if (!misspelt.empty() && name.starts_with(std::string(misspelt) + "_"))
      return ", did you mean '" + name + "'?";
    const std::size_t distance = edit_distance(misspelt, name);
    if (distance < best && distance < name.size()) {
      best = distance;
      nearest = &name;
    }
  }
  return nearest ? ", did you mean '" + *nearest + "'?" : "";
}

std::expected<Endpoint, std::string> parse_endpoint(std::string_view text, std::uint16_t least_port) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0)
    return std::unexpected("expected host:port, found " + in_quotes(text));
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return std::unexpected("expected host:port, found " + in_quotes(text) +
                           ": an IPv6 address stands in brackets");
  }
  const std::string_view digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || stop != digits.data() + digits.size() || port < least_port) {
    return std::unexpected("expected a port of " + std::to_string(least_port) + "..65535, found " +
                           in_quotes(digits));
  }
  return Endpoint{std::string{host}, port};
}

std::string text(const Endpoint& endpoint) { return text::host_port(endpoint.host, endpoint.port); }

}  // namespace truepose::config
