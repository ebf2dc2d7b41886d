#include "config/parameter_csv.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "config/number_text.hpp"

namespace truepose::config {

namespace {

/// Of a deviation's coefficient: of its joint, per unit of its basis.
std::string unit_of_deviation(std::string_view joint, std::string_view basis, const RobotModel& robot) {
  const auto number = static_cast<std::size_t>(std::stoi(std::string(joint.substr(5))));
  const bool moves = number <= robot.joints.size() && robot.joints[number - 1].type == JointType::Prismatic;
  const std::string unit = moves ? "mm" : "rad";
  if (basis.starts_with("gravity")) return unit + (moves ? "/kN" : "/kNm");
  if (basis.starts_with("weight")) return unit + (moves ? "" : "/m");
  return basis == "scale" ? unit + "/m" : unit;
}

/// By the words of the name: link3.alpha, base.rx, joint2.gravity.
std::string unit_of(std::string_view name, const RobotModel& robot) {
  constexpr std::array<std::string_view, 6> kAngles{"alpha", "theta", "beta", "rx", "ry", "rz"};
  const std::size_t dot = name.rfind('.');
  const std::string_view first = name.substr(0, dot), last = name.substr(dot + 1);
  if (first.starts_with("joint")) return unit_of_deviation(first, last, robot);
  return std::ranges::find(kAngles, last) != kAngles.end() ? "rad" : "mm";
}

/// As RFC 4180 has it: reflectors may have any name.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

std::string parameter_csv(std::span<const IdentifiedParameter> parameters, const RobotModel& robot) {
  std::string text = "name,unit,nominal,value,deviation,sigma,identified,data_share\n";
  for (const IdentifiedParameter& p : parameters) {
    const bool has_data_sheet = p.name.starts_with("link");
    text += field(p.name);
    text += ',';
    text += unit_of(p.name, robot);
    text += ',';
    if (has_data_sheet) text += format_number(p.nominal);
    text += ',' + format_number(p.value) + ',';
    if (has_data_sheet) text += format_number(p.value - p.nominal);
    text += ',';
    if (p.identified) text += format_number(p.sigma);
    text += p.identified ? ",true," : ",false,";
    text += format_number(p.data_share) + '\n';
  }
  return text;
}

}  // namespace truepose::config
