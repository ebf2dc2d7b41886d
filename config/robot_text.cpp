#include "config/robot_text.hpp"

#include "config/number_text.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"
#include "core/math/rounding.hpp"

namespace truepose::config {
namespace {

std::string pairs(std::initializer_list<std::pair<const char*, double>> numbers) {
  std::string text;
  for (const auto& [key, value] : numbers)
    text += (text.empty() ? "" : ", ") + std::string{key} + ": " + format_number(without_rounding(value));
  return text;
}

std::string mass_text(const LinkMass& mass) {
  const Eigen::Vector3d& c = mass.centre_mm;
  return "{" + pairs({{"kg", mass.mass_kg}, {"x", c.x()}, {"y", c.y()}, {"z", c.z()}}) + "}";
}

std::string joint_row(const Joint& joint, const LinkMass* mass) {
  const double unit = unit_of(joint);
  std::string text = joint.type == JointType::Prismatic ? "type: prismatic, " : "";
  text += pairs({{"a", joint.a_mm},
                 {"alpha", joint.alpha_rad * kDegPerRad},
                 {"d", joint.d_mm},
                 {"theta", joint.theta_rad * kDegPerRad},
                 {"beta", joint.beta_rad * kDegPerRad},
                 {"sign", joint.sign},
                 {"min", joint.min / unit},
                 {"max", joint.max / unit},
                 {"speed", joint.speed / unit}});
  if (joint.acceleration > 0) text += ", " + pairs({{"acceleration", joint.acceleration / unit}});
  if (mass) text += ",\n     mass: " + mass_text(*mass);
  return "  - {" + text + "}\n";
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

}  // namespace

std::string coupling_text(const JointCoupling& coupling) {
  return "{joint: " + std::to_string(coupling.joint + 1) + ", to: " + std::to_string(coupling.to + 1) + ", " +
         pairs({{"factor", coupling.factor}}) + "}";
}

std::string robot_text(const RobotModel& robot, const std::vector<std::string>& comment) {
  std::string text;
  for (const std::string& line : comment) text += "# " + line + "\n";
  text += "name: " + quoted(robot.name) + "\njoints:\n";
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    text += joint_row(robot.joints[i], robot.masses.empty() ? nullptr : &robot.masses[i]);
  if (!robot.coupling.empty()) {
    text += "coupling: [";
    for (std::size_t i = 0; i < robot.coupling.size(); ++i)
      text += (i > 0 ? ", " : "") + coupling_text(robot.coupling[i]);
    text += "]\n";
  }
  const Eigen::Vector3d p = robot.X_flange.translation(), abc = kuka_abc_deg(robot.X_flange.linear());
  return text + "flange: {" +
         pairs({{"x", p.x()}, {"y", p.y()}, {"z", p.z()}, {"a", abc.x()}, {"b", abc.y()}, {"c", abc.z()}}) +
         "}\n";
}

}  // namespace truepose::config
