#include "config/import/xacro_expression.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "config/number_text.hpp"
#include "core/math/angles.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::config {
namespace {

/// What is wrong with the expression. Does not leave this file.
struct NotUnderstood {
  std::string why;
};

using ValueOf = std::function<std::optional<XacroValue>(const std::string&)>;

struct XacroFunction {
  std::string_view name;
  std::size_t least, most;
  double (*value)(std::span<const double>);
};

constexpr std::array kFunctions{
    XacroFunction{"radians", 1, 1, [](std::span<const double> x) { return x[0] * kRadPerDeg; }},
    XacroFunction{"degrees", 1, 1, [](std::span<const double> x) { return x[0] * kDegPerRad; }},
    XacroFunction{"sin", 1, 1, [](std::span<const double> x) { return std::sin(x[0]); }},
    XacroFunction{"cos", 1, 1, [](std::span<const double> x) { return std::cos(x[0]); }},
    XacroFunction{"tan", 1, 1, [](std::span<const double> x) { return std::tan(x[0]); }},
    XacroFunction{"asin", 1, 1, [](std::span<const double> x) { return std::asin(x[0]); }},
    XacroFunction{"acos", 1, 1, [](std::span<const double> x) { return std::acos(x[0]); }},
    XacroFunction{"atan", 1, 1, [](std::span<const double> x) { return std::atan(x[0]); }},
    XacroFunction{"atan2", 2, 2, [](std::span<const double> x) { return std::atan2(x[0], x[1]); }},
    XacroFunction{"sqrt", 1, 1, [](std::span<const double> x) { return std::sqrt(x[0]); }},
    XacroFunction{"abs", 1, 1, [](std::span<const double> x) { return std::abs(x[0]); }},
    XacroFunction{"min", 2, 9, [](std::span<const double> x) { return *std::ranges::min_element(x); }},
    XacroFunction{"max", 2, 9, [](std::span<const double> x) { return *std::ranges::max_element(x); }},
    XacroFunction{"float", 1, 1, [](std::span<const double> x) { return x[0]; }},
    XacroFunction{"int", 1, 1, [](std::span<const double> x) { return std::trunc(x[0]); }}};

bool is_true(const XacroValue& value) {
  if (const double* number = std::get_if<double>(&value)) return *number != 0;
  return !std::get<std::string>(value).empty();
}

double number_of(const XacroValue& value) {
  if (const double* number = std::get_if<double>(&value)) return *number;
  throw NotUnderstood{in_quotes(std::get<std::string>(value)) + " is not a number"};
}

/// Reads from the weakest operator down to a single value.
class Reader {
 public:
  Reader(std::string_view text, const ValueOf& value_of) : text_{text}, value_of_{value_of} {}

  XacroValue whole() {
    const XacroValue value = choice();
    skip_blanks();
    if (at_ < text_.size()) fail("did not expect " + in_quotes(text_.substr(at_)));
    return value;
  }

 private:
  [[noreturn]] static void fail(const std::string& why) { throw NotUnderstood{why}; }

  void skip_blanks() {
    while (at_ < text_.size() && xml::is_space(text_[at_])) ++at_;
  }
  static bool is_of_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
  bool take(std::string_view symbol) {
    skip_blanks();
    if (!text_.substr(at_).starts_with(symbol)) return false;
    const std::size_t end = at_ + symbol.size();
    // A word ends where no letter follows.
    if (is_of_name(symbol.back()) && end < text_.size() && is_of_name(text_[end])) return false;
    at_ = end;
    return true;
  }

  XacroValue choice() {
    if (++depth_ > kMostDepth) fail("is nested too deeply");
    XacroValue value = disjunction();
    if (take("if")) {
      const XacroValue condition = disjunction();
      if (!take("else")) fail("expected else behind if");
      const XacroValue other = choice();
      if (!is_true(condition)) value = other;
    }
    --depth_;
    return value;
  }
  XacroValue disjunction() {
    XacroValue value = conjunction();
    while (take("or")) {
      const XacroValue other = conjunction();
      if (!is_true(value)) value = other;
    }
    return value;
  }
  XacroValue conjunction() {
    XacroValue value = negation();
    while (take("and")) {
      const XacroValue other = negation();
      if (is_true(value)) value = other;
    }
    return value;
  }
  XacroValue negation() {
    bool turned = false, any = false;
    while (take("not")) {
      turned = !turned;
      any = true;
    }
    const XacroValue value = comparison();
    return any ? XacroValue{is_true(value) != turned ? 1.0 : 0.0} : value;
  }
  XacroValue comparison() {
    const XacroValue left = sum();
    if (take("==")) return left == sum() ? 1.0 : 0.0;
    if (take("!=")) return left != sum() ? 1.0 : 0.0;
    if (take("<=")) return number_of(left) <= number_of(sum()) ? 1.0 : 0.0;
    if (take(">=")) return number_of(left) >= number_of(sum()) ? 1.0 : 0.0;
    if (take("<")) return number_of(left) < number_of(sum()) ? 1.0 : 0.0;
    if (take(">")) return number_of(left) > number_of(sum()) ? 1.0 : 0.0;
    return left;
  }
  XacroValue sum() {
    XacroValue value = product();
    while (true) {
      if (take("+")) {
        const XacroValue right = product();
        const auto* head = std::get_if<std::string>(&value);
        const auto* tail = std::get_if<std::string>(&right);
        value = head && tail ? XacroValue{*head + *tail} : XacroValue{number_of(value) + number_of(right)};
      } else if (take("-")) {
        value = number_of(value) - number_of(product());
      } else {
        return value;
      }
    }
  }
  XacroValue product() {
    XacroValue value = signed_value();
    while (true) {
      if (take("*")) {
        value = number_of(value) * number_of(signed_value());
      } else if (take("/")) {
        const double divisor = number_of(signed_value());
        if (divisor == 0) fail("division by 0");
        value = number_of(value) / divisor;
      } else if (take("%")) {
        const double divisor = number_of(signed_value());
        if (divisor == 0) fail("division by 0");
        const double left = number_of(value);
        value = left - divisor * std::floor(left / divisor);
      } else {
        return value;
      }
    }
  }
  XacroValue signed_value() {
    if (++depth_ > kMostDepth) fail("is nested too deeply");
    const XacroValue value = take("-")   ? XacroValue{-number_of(signed_value())}
                             : take("+") ? XacroValue{number_of(signed_value())}
                                         : power();
    --depth_;
    return value;
  }
  XacroValue power() {
    const XacroValue base = single();
    if (!take("**")) return base;
    return std::pow(number_of(base), number_of(signed_value()));
  }
  XacroValue single() {
    skip_blanks();
    if (at_ >= text_.size()) fail("ends too early");
    const char c = text_[at_];
    if (take("(")) {
      const XacroValue value = choice();
      if (!take(")")) fail("a ) is missing");
      return value;
    }
    if (c == '\'' || c == '"') return quoted(c);
    if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') return number();
    if (is_of_name(c)) return named();
    fail("did not expect " + in_quotes(text_.substr(at_)));
  }
  XacroValue quoted(char mark) {
    const std::size_t end = text_.find(mark, at_ + 1);
    if (end == std::string_view::npos) fail("a quote is not closed");
    const std::string text{text_.substr(at_ + 1, end - at_ - 1)};
    at_ = end + 1;
    return text;
  }
  XacroValue number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc{}) fail("not a number: " + in_quotes(text_.substr(at_)));
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }
  XacroValue named() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_of_name(text_[at_])) ++at_;
    const std::string name{text_.substr(begin, at_ - begin)};
    skip_blanks();
    if (take("(")) return call(name);
    if (at_ < text_.size() && (text_[at_] == '.' || text_[at_] == '['))
      fail(in_quotes(name) + ": members and elements are not understood; only numbers and texts are");
    if (const auto value = value_of_(name)) return *value;
    if (name == "pi" || name == "PI") return std::numbers::pi;
    if (name == "True" || name == "true") return 1.0;
    if (name == "False" || name == "false") return 0.0;
    fail(in_quotes(name) + " is not defined");
  }
  XacroValue call(const std::string& name) {
    std::vector<XacroValue> values;
    while (!take(")")) {
      if (!values.empty() && !take(",")) fail("expected , or ) in " + name + "()");
      values.push_back(choice());
    }
    if (name == "str" && values.size() == 1) return xacro_text(values[0]);
    const auto* function = std::ranges::find(kFunctions, std::string_view{name}, &XacroFunction::name);
    if (function == kFunctions.end()) fail("the function " + name + "() is not known");
    if (values.size() < function->least || values.size() > function->most)
      fail(name + "() has " + std::to_string(values.size()) + " arguments");
    std::vector<double> numbers;
    for (const XacroValue& value : values) numbers.push_back(number_of(value));
    return function->value(numbers);
  }

  static constexpr int kMostDepth = 100;
  std::string_view text_;
  const ValueOf& value_of_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

std::string xacro_text(const XacroValue& value) {
  if (const double* number = std::get_if<double>(&value)) return format_number(*number);
  return std::get<std::string>(value);
}

XacroValue xacro_value(const std::string& text) {
  if (const auto number = xml::to_number<double>(text)) return *number;
  if (text == "true" || text == "True") return 1.0;
  if (text == "false" || text == "False") return 0.0;
  return text;
}

std::expected<XacroValue, std::string> evaluate_xacro(std::string_view expression, const ValueOf& value_of) {
  try {
    const XacroValue value = Reader{expression, value_of}.whole();
    const double* number = std::get_if<double>(&value);
    if (number && !std::isfinite(*number)) return std::unexpected{"is not a finite number"};
    return value;
  } catch (const NotUnderstood& fault) {
    return std::unexpected{fault.why};
  }
}

}  // namespace truepose::config
