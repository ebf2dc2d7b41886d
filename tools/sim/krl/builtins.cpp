#include "tools/sim/krl/builtins.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/statement_reader.hpp"

namespace truepose::sim::krl {
namespace {

using Arguments = std::vector<Value>;
constexpr double kRadianPerDegree = std::numbers::pi / 180;

double number_at(const Arguments& arguments, std::size_t i) { return number_of(arguments[i]); }

Value square_root(Arguments& arguments) {
  const double number = number_at(arguments, 0);
  if (number < 0) throw Fault{.what = "SQRT of a number below 0"};
  return std::sqrt(number);
}

Value arc_cosine(Arguments& arguments) {
  const double number = number_at(arguments, 0);
  if (std::abs(number) > 1) throw Fault{.what = "ACOS of a number outside of -1 to 1"};
  return std::acos(number) / kRadianPerDegree;
}

Value sine(Arguments& arguments) { return std::sin(number_at(arguments, 0) * kRadianPerDegree); }
Value cosine(Arguments& arguments) { return std::cos(number_at(arguments, 0) * kRadianPerDegree); }
Value tangent(Arguments& arguments) { return std::tan(number_at(arguments, 0) * kRadianPerDegree); }

Value arc_tangent(Arguments& arguments) {
  return std::atan2(number_at(arguments, 0), number_at(arguments, 1)) / kRadianPerDegree;
}

bool put(Value& array, std::string_view text) { return fill(std::get<std::string>(array), text); }

Value length(Arguments& arguments) { return static_cast<std::int32_t>(text_of(arguments[0]).size()); }

Value declared_length(Arguments& arguments) {
  return static_cast<std::int32_t>(std::get<std::string>(arguments[0]).size());
}

Value clear(Arguments& arguments) { return put(arguments[0], ""); }

Value copy(Arguments& arguments) { return put(arguments[0], text_of(arguments[1])); }

Value append(Arguments& arguments) {
  const std::string text = text_of(arguments[0]) + text_of(arguments[1]);
  return put(arguments[0], text) ? static_cast<std::int32_t>(text.size()) : std::int32_t{0};
}

Value compare(Arguments& arguments) {
  const std::string left = text_of(arguments[0]), right = text_of(arguments[1]);
  const bool minds_case = std::get<Literal>(arguments[2]).name == "CASE_SENS";
  return minds_case ? left == right : in_capitals(left) == in_capitals(right);
}

Value write(Arguments& arguments) {
  write_string(arguments);
  return {};
}

Value read(Arguments& arguments) {
  read_string(arguments);
  return {};
}

}  // namespace

Value call_builtin(std::string_view name, std::vector<Value>& arguments) {
  static const std::map<std::string_view, Value (*)(Arguments&)> kFunctions = {
      {"SQRT", square_root}, {"SIN", sine},          {"COS", cosine},    {"TAN", tangent},
      {"ACOS", arc_cosine},  {"ATAN2", arc_tangent}, {"STRLEN", length}, {"STRDECLLEN", declared_length},
      {"STRCLEAR", clear},   {"STRCOPY", copy},      {"STRADD", append}, {"STRCOMP", compare},
      {"SWRITE", write},     {"SREAD", read}};
  return kFunctions.at(name)(arguments);
}

}  // namespace truepose::sim::krl
