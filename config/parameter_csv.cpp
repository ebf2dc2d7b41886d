#include "config/parameter_csv.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "config/number_text.hpp"
#include "core/arm/joint_deviation.hpp"

namespace truepose::config {

namespace {

/// Of a coefficient: of what its joint moves by, per unit of its basis.
std::string unit_of(const DeviationTerm& term, const RobotModel& robot) {
  const Joint& joint = robot.joints[static_cast<std::size_t>(term.joint)];
  const bool revolute = joint.type == JointType::Revolute;
  const std::string unit = revolute ? "rad" : "mm";
  switch (term.basis) {
    case DeviationBasis::Gravity:
      return unit + (revolute ? "/kNm" : "/kN");
    case DeviationBasis::Weight:
      return unit + (revolute ? "/m" : "");
    case DeviationBasis::Scale:
      return unit + "/m";
    default:
      return unit;
  }
}

/// Of a deviation of the robot, or else by the last word of the name: link3.alpha, base.rx.
std::string unit_of(std::string_view name, const RobotModel& robot) {
  for (const DeviationTerm& term : robot.deviation) {
    if (deviation_name(term) == name) return unit_of(term, robot);
  }
  constexpr std::array<std::string_view, 6> kAngles{"alpha", "theta", "beta", "rx", "ry", "rz"};
  const std::string_view last = name.substr(name.rfind('.') + 1);
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
