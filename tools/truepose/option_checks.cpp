// What the value of an option may be, and what is said of one that may not.
#include <algorithm>
#include <array>
#include <charconv>

#include "config/number_text.hpp"
#include "proto/text/renamed.hpp"
#include "tools/truepose/command_line.hpp"

namespace truepose::tools {
namespace {

/// Without an exponent: "0.000001".
std::string plain(double value) {
  std::array<char, 64> text;
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  return error == std::errc{} ? std::string{text.data(), end} : config::format_number(value);
}

/// @param shown  "2 to 10000"
Check range(double least, double most, const std::string& shown) {
  return {"From " + shown, [=](const std::string& text) -> std::string {
            const auto value = config::parse_number(text);
            if (value && *value >= least && *value <= most) return {};
            const bool is_percent = value && most <= 1 && *value > 1 && *value <= 100 * most;
            return text + " is out of range. Give " + shown +
                   (is_percent ? ": " + config::format_number(*value / 100) + " for " + text + " %" : "");
          }};
}

}  // namespace

Check in_range(int least, int most) {
  return range(least, most, std::to_string(least) + " to " + std::to_string(most));
}

Check in_range(double least, double most) { return range(least, most, plain(least) + " to " + plain(most)); }

Check available(const std::vector<std::string_view>& values) {
  const std::vector<std::string> names{values.begin(), values.end()};
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  const auto why_not = [names, all](const std::string& value) -> std::string {
    if (std::ranges::find(names, value) != names.end()) return {};
    return "'" + value + "' is not available in this version (available: " + all + ")" +
           config::suggestion(value, names);
  };
  return {"", why_not, names};
}

}  // namespace truepose::tools
