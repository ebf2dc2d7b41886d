#include "config/parameter_csv.hpp"

#include <array>
#include <string_view>

#include "config/number_text.hpp"

namespace truepose::config {

namespace {

/// By the last word of the name: link3.alpha, base.rx.
std::string_view unit_of(std::string_view name) {
  constexpr std::array<std::string_view, 6> kAngles{"alpha", "theta", "beta", "rx", "ry", "rz"};
  const std::string_view last = name.substr(name.rfind('.') + 1);
  for (const std::string_view angle : kAngles) {
    if (last == angle) return "rad";
  }
  return "mm";
}

/// As RFC 4180 has it: reflectors may have any name.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

std::string parameter_csv(std::span<const IdentifiedParameter> parameters) {
  std::string text = "name,unit,nominal,value,deviation,sigma,identified\n";
  for (const IdentifiedParameter& p : parameters) {
    const bool has_data_sheet = p.name.starts_with("link");
    text += field(p.name);
    text += ',';
    text += unit_of(p.name);
    text += ',';
    if (has_data_sheet) text += format_number(p.nominal);
    text += ',' + format_number(p.value) + ',';
    if (has_data_sheet) text += format_number(p.value - p.nominal);
    text += ',';
    if (p.identified) text += format_number(p.sigma);
    text += p.identified ? ",true\n" : ",false\n";
  }
  return text;
}

}  // namespace truepose::config
