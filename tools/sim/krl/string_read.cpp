#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "tools/sim/krl/builtins.hpp"
#include "tools/sim/krl/conversion.hpp"

namespace truepose::sim::krl {
namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// A text that is read from its beginning.
class FormatReader {
 public:
  explicit FormatReader(std::string_view text) : rest_{text} {}

  bool at_end() const { return rest_.empty(); }
  std::size_t left() const { return rest_.size(); }

  void skip_spaces() {
    while (!rest_.empty() && is_space(rest_[0])) rest_.remove_prefix(1);
  }
  bool skip(char c) {
    if (rest_.empty() || rest_[0] != c) return false;
    rest_.remove_prefix(1);
    return true;
  }

  /// Reads what a conversion says into a variable of a type. @return whether it stands there
  bool read(const Conversion& conversion, std::string_view type, Value& variable) {
    if (conversion.letter == 'c') return type == "CHAR" && read_character(variable);
    skip_spaces();
    switch (conversion.letter) {
      case 'd':
      case 'i':
        return read_whole(conversion, 10, type, variable);
      case 'x':
        return read_whole(conversion, 16, type, variable);
      case 'e':
      case 'f':
      case 'F':
      case 'g':
        return type == "REAL" && read_real(conversion, variable);
      case 's':
        return type == "TEXT" && read_word(conversion, variable);
      default:
        return false;
    }
  }

 private:
  std::string_view within(const Conversion& conversion) const {
    return conversion.width > 0 ? rest_.substr(0, static_cast<std::size_t>(conversion.width)) : rest_;
  }

  template <typename Number, typename... How>
  bool take(const Conversion& conversion, Number& number, How... how) {
    std::string_view field = within(conversion);
    const bool has_plus = field.size() > 1 && field[0] == '+' && field[1] != '-';
    if (has_plus) field.remove_prefix(1);
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), number, how...);
    if (error != std::errc{}) return false;
    rest_.remove_prefix(static_cast<std::size_t>(end - field.data()) + (has_plus ? 1 : 0));
    return true;
  }

  bool read_character(Value& variable) {
    if (rest_.empty()) return false;
    variable = rest_[0];
    rest_.remove_prefix(1);
    return true;
  }

  bool read_whole(const Conversion& conversion, int base, std::string_view type, Value& variable) {
    std::int32_t number = 0;
    if (!take(conversion, number, base)) return false;
    if (type == "BOOL") {
      variable = number != 0;
      return true;
    }
    variable = number;
    return type == "INT";
  }

  bool read_real(const Conversion& conversion, Value& variable) {
    double number = 0;
    if (!take(conversion, number) || !std::isfinite(static_cast<float>(number))) return false;
    variable = number;
    return true;
  }

  bool read_word(const Conversion& conversion, Value& variable) {
    const std::string_view field = within(conversion);
    const std::string_view word =
        field.substr(0, static_cast<std::size_t>(std::ranges::find_if(field, is_space) - field.begin()));
    auto* const array = std::get_if<std::string>(&variable);
    if (!array || word.empty() || !fill(*array, word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

  std::string_view rest_;
};

/// A blank in the format stands for any number of them. @return how many values were read
int read_values(FormatReader& reader, const std::string& format, std::vector<Value>& arguments,
                bool& is_good) {
  int values = 0;
  std::size_t next = 4;
  for (std::size_t at = 0; at < format.size() && is_good;) {
    const char c = format[at++];
    if (is_space(c)) {
      reader.skip_spaces();
    } else if (c != '%' || (at < format.size() && format[at] == '%')) {
      is_good = reader.skip(c);
      at += c == '%' ? 1 : 0;
    } else {
      const Conversion conversion = read_conversion(format, at);
      is_good = next < arguments.size() &&
                reader.read(conversion, std::get<Literal>(arguments[next + 1]).name, arguments[next]);
      values += is_good ? 1 : 0;
      next += 2;
    }
  }
  return values;
}

}  // namespace

void read_string(std::vector<Value>& arguments) {
  const std::string text = text_of(arguments[0]);
  const auto* const given = std::get_if<std::int32_t>(&arguments[2]);
  const std::size_t offset =
      std::min(static_cast<std::size_t>(given && *given > 0 ? *given : 0), text.size());
  FormatReader reader{std::string_view{text}.substr(offset)};
  bool is_good = true;
  const int values = read_values(reader, text_of(arguments[3]), arguments, is_good);
  const char* const state = is_good ? "CMD_OK" : reader.at_end() ? "DATA_END" : "FMT_ERR";
  const std::size_t end = text.size() - reader.left();
  arguments[2] = static_cast<std::int32_t>(end);
  arguments[1] = Parts{Literal{state}, values, static_cast<std::int32_t>(end - offset)};
}

}  // namespace truepose::sim::krl
