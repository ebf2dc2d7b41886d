#include "config/model_export.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/joint_deviation.hpp"
#include "core/math/angles.hpp"
#include "proto/record/forms.hpp"

namespace truepose::config {

namespace {

/// Of a coefficient: of what its joint moves by, per unit of its basis.
std::string unit_of(const DeviationTerm& term, const RobotModel& robot) {
  const Joint& joint = robot.joints[static_cast<std::size_t>(term.joint)];
  const bool revolute = joint.type == JointType::Revolute;
  const std::string unit = moves_along(robot, term) ? "mm" : "rad";
  switch (term.basis) {
    case DeviationBasis::Gravity:
      return unit + (revolute ? "/kNm" : "/kN");
    case DeviationBasis::Weight:
    case DeviationBasis::MomentX:
    case DeviationBasis::MomentY:
    case DeviationBasis::MomentZ:
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

constexpr double kMetrePerMm = 1e-3;

std::string in_attribute(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += c;
    }
  }
  return result;
}

std::string triple(const Eigen::Vector3d& v) {
  return format_number(v.x()) + ' ' + format_number(v.y()) + ' ' + format_number(v.z());
}

/// URDF's roll, pitch and yaw are rx, ry and rz.
std::string origin(const Eigen::Isometry3d& X) {
  return "    <origin xyz=\"" + triple(X.translation() * kMetrePerMm) + "\" rpy=\"" +
         triple(angles_zyx(X.linear())) + "\"/>\n";
}

std::string between(const std::string& parent, const std::string& child) {
  return "    <parent link=\"" + parent + "\"/>\n    <child link=\"" + child + "\"/>\n";
}

/// The arm with the limits that a joint of the chain has where the controller's joints have theirs.
RobotModel uncoupled(RobotModel robot) {
  const std::vector<Joint> joints = robot.joints;
  for (const JointCoupling& each : robot.coupling) {
    const Joint& to = joints[static_cast<std::size_t>(each.to)];
    const auto [least, most] = std::minmax({each.factor * to.min, each.factor * to.max});
    Joint& joint = robot.joints[static_cast<std::size_t>(each.joint)];
    joint.min += least;
    joint.max += most;
    joint.speed += std::abs(each.factor) * to.speed;
  }
  return robot;
}

/// Theta and d stand behind the joint's own motion but commute with it, so the joint at q = 0 is its origin.
std::string joint_text(const Joint& joint, const std::string& number, const std::string& parent) {
  const bool revolute = joint.type == JointType::Revolute;
  const double unit = revolute ? 1 : kMetrePerMm;
  const std::string axis = triple({0, 0, joint.sign});
  return "  <joint name=\"joint_" + number + "\" type=\"" +
         std::string(name_of(record::kJointTypes, joint.type)) + "\">\n" + between(parent, "link_" + number) +
         origin(link_transform(joint, 0)) + "    <axis xyz=\"" + axis + "\"/>\n    <limit lower=\"" +
         format_number(joint.min * unit) + "\" upper=\"" + format_number(joint.max * unit) +
         "\" velocity=\"" + format_number(joint.speed * unit) + "\" effort=\"0\"/>\n  </joint>\n";
}

/// What the file holds of the arm, and what it cannot.
std::string comment(const RobotModel& robot) {
  std::string left_out;
  if (!robot.deviation.empty()) left_out = "the deviations of its joints";
  if (robot.field) left_out += std::string(left_out.empty() ? "" : " and ") + "its residual field";
  if (!left_out.empty()) left_out = " Without " + left_out + ", which URDF cannot hold.";
  std::string coupled;
  for (const JointCoupling& each : robot.coupling) {
    const std::string joint = std::to_string(each.joint + 1), to = std::to_string(each.to + 1);
    coupled += " joint_" + joint + " takes the controller's q" + joint + " + " + format_number(each.factor) +
               " * q" + to + ".";
  }
  return "<!-- Kinematics alone. m and rad." + coupled + left_out + " -->\n";
}

}  // namespace

std::string parameter_csv(std::span<const IdentifiedParameter> parameters, const RobotModel& robot) {
  std::string text = "name,unit,nominal,value,deviation,sigma,identified,data_share\n";
  for (const IdentifiedParameter& p : parameters) {
    const bool has_data_sheet = p.name.starts_with("link");
    text += csv_field(p.name);
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

std::string urdf(const RobotModel& calibrated) {
  const RobotModel robot = uncoupled(calibrated);
  std::string text = "<?xml version=\"1.0\"?>\n" + comment(robot);
  text += "<robot name=\"" + in_attribute(robot.name) + "\">\n  <link name=\"base_link\"/>\n";
  std::string parent = "base_link";
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    text += "  <link name=\"link_" + number + "\"/>\n" + joint_text(robot.joints[i], number, parent);
    parent = "link_" + number;
  }
  return text + "  <link name=\"flange\"/>\n  <joint name=\"joint_flange\" type=\"fixed\">\n" +
         between(parent, "flange") + origin(robot.X_flange) + "  </joint>\n</robot>\n";
}

}  // namespace truepose::config
