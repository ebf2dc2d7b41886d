#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>

#include "tools/sim/krl/builtins.hpp"
#include "tools/sim/krl/conversion.hpp"

namespace truepose::sim::krl {
namespace {

template <typename T>
std::string printed(const char* format, int width, int digits, T value) {
  std::string text(static_cast<std::size_t>(Conversion::kWidest) * 4, '\0');
  const int length = std::snprintf(text.data(), text.size(), format, width, digits, value);
  text.resize(std::min(text.size(), static_cast<std::size_t>(std::max(length, 0))));
  return text;
}

std::optional<std::string> converted(const Conversion& conversion, const Value& value) {
  const int digits = conversion.digits.value_or(-1);
  const auto* whole = std::get_if<std::int32_t>(&value);
  const bool is_number = whole || std::holds_alternative<double>(value);
  switch (conversion.letter) {
    case 'd':
    case 'i':
      if (const auto* truth = std::get_if<bool>(&value))
        return printed("%*.*d", conversion.width, digits, *truth ? 1 : 0);
      return whole ? std::optional{printed("%*.*d", conversion.width, digits, *whole)} : std::nullopt;
    case 'x':
      if (!whole) return std::nullopt;
      return printed("%*.*x", conversion.width, digits, static_cast<unsigned>(*whole));
    case 'f':
    case 'F':
      return is_number ? std::optional{printed("%*.*f", conversion.width, digits, number_of(value))}
                       : std::nullopt;
    case 'e':
    case 'g':
      if (!is_number) return std::nullopt;
      return printed(conversion.letter == 'e' ? "%*.*e" : "%*.*g", conversion.width, digits,
                     number_of(value));
    case 's':
      if (!std::holds_alternative<std::string>(value)) return std::nullopt;
      return printed("%*.*s", conversion.width, digits, text_of(value).c_str());
    case 'c':
      if (const auto* character = std::get_if<char>(&value)) return std::string(1, *character);
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

struct Written {
  std::string text;
  int values = 0;
  bool is_good = true;
};

/// The text of the values, and how many of them were written.
Written write_values(const std::string& format, const std::vector<Value>& arguments) {
  Written written;
  std::size_t next = 4;
  for (std::size_t at = 0; at < format.size();) {
    if (format[at] != '%') {
      written.text += format[at++];
    } else if (at + 1 < format.size() && format[at + 1] == '%') {
      written.text += '%';
      at += 2;
    } else {
      const Conversion conversion = read_conversion(format, ++at);
      const auto text = next < arguments.size() ? converted(conversion, arguments[next]) : std::nullopt;
      if (!text) {
        written.is_good = false;
        return written;
      }
      written.text += *text;
      ++written.values;
      ++next;
    }
  }
  return written;
}

}  // namespace

void write_string(std::vector<Value>& arguments) {
  std::string target = std::get<std::string>(arguments[0]);
  const auto* given = std::get_if<std::int32_t>(&arguments[2]);
  const std::size_t offset = given && *given > 0 ? static_cast<std::size_t>(*given) : 0;
  const Written written = write_values(text_of(arguments[3]), arguments);
  const bool fits = written.is_good && offset + written.text.size() <= target.size();
  if (fits) {
    target.replace(offset, written.text.size(), written.text);
    arguments[0] = target;
    arguments[2] = static_cast<std::int32_t>(offset + written.text.size());
  }
  arguments[1] = Parts{Literal{fits ? "CMD_OK" : "FMT_ERR"}, written.values,
                       fits ? static_cast<std::int32_t>(written.text.size()) : std::int32_t{0}};
}

}  // namespace truepose::sim::krl
