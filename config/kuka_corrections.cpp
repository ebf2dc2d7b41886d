#include <array>
#include <cmath>
#include <map>

#include "config/model_export.hpp"
#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {
namespace {

/// More than any arm deviates from its data sheet.
constexpr double kMostDeg = 2, kMost_mm = 20;

/// The rows of machine_data.cpp: then a length of a row is a number of $machine.dat.
bool has_kuka_rows(const RobotModel& robot) {
  constexpr std::array kAlphaDeg{0.0, -90.0, 0.0, -90.0, 90.0, -90.0};
  if (robot.joints.size() != kAlphaDeg.size()) return false;
  for (std::size_t i = 0; i < kAlphaDeg.size(); ++i) {
    if (std::abs(robot.joints[i].alpha_rad * kDegPerRad - kAlphaDeg[i]) > kMostDeg) return false;
  }
  return std::hypot(robot.joints[1].d_mm, robot.joints[2].d_mm) < kMost_mm;
}

const std::map<std::string, std::string> kMachineData{
    {"link1.d", "$TIRORO.Z"},     {"link2.a", "$LENGTH_A"},     {"link3.a", "$LENGTH_B"},
    {"link4.a", "$TX3P3.Z"},      {"link4.d", "$TX3P3.X"},      {"link5.a", "$DH_4.DHART_A"},
    {"link5.d", "$DH_4.DHART_D"}, {"link6.a", "$DH_5.DHART_A"}, {"link6.d", "$TFLWP.Z"}};

constexpr const char* kNoPlace = "no place in the controller: needs corrected positions";

/// @param joint  of the parameter's row
std::string where(const std::string& name, const std::string& parameter, std::size_t joint, bool has_rows) {
  if (parameter == "theta") return "zero of axis " + std::to_string(joint + 1) + " (mastering)";
  const auto found = kMachineData.find(name);
  if (found == kMachineData.end() || !has_rows) return kNoPlace;
  return "$machine.dat " + found->second + " (by KUKA alone on most controllers)";
}

}  // namespace

std::string kuka_corrections_csv(std::span<const IdentifiedParameter> parameters, const RobotModel& robot) {
  const bool has_rows = has_kuka_rows(robot);
  std::string text = "row,parameter,unit,nominal,value,change,where\n";
  for (const IdentifiedParameter& p : parameters) {
    const std::size_t dot = p.name.find('.');
    if (!p.name.starts_with("link") || dot == std::string::npos || p.value == p.nominal) continue;
    const auto row = parse_number(std::string_view{p.name}.substr(4, dot - 4));
    if (!row || *row < 1 || *row > static_cast<double>(robot.joints.size())) continue;
    const std::size_t joint = static_cast<std::size_t>(*row) - 1;
    const std::string parameter = p.name.substr(dot + 1);
    const bool is_length = parameter == "a" || parameter == "d";
    // A zero is what is added to the angle that the controller shows, which counts as the row's sign says.
    const double unit = is_length ? 1 : kDegPerRad,
                 sign = parameter == "theta" ? robot.joints[joint].sign : 1;
    text += format_number(*row) + ',' + parameter + (is_length ? ",mm," : ",deg,") +
            format_number(p.nominal * unit) + ',' + format_number(p.value * unit) + ',' +
            format_number(sign * (p.value - p.nominal) * unit) + ',' +
            csv_field(where(p.name, parameter, joint, has_rows)) + '\n';
  }
  return text;
}

}  // namespace truepose::config
