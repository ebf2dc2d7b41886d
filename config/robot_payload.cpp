#include "config/robot_payload.hpp"

#include "config/yaml_poses.hpp"

namespace truepose::config {
namespace {

/// One mass in place of two that move together.
LinkMass together(const LinkMass& a, const LinkMass& b) {
  const double sum_kg = a.mass_kg + b.mass_kg;
  if (sum_kg == 0) return a;
  return {.mass_kg = sum_kg, .centre_mm = (a.mass_kg * a.centre_mm + b.mass_kg * b.centre_mm) / sum_kg};
}

}  // namespace

void add_payload(RobotModel& robot, const YamlValue& value) {
  if (robot.masses.empty()) value.fail("expected a mass for every joint too");
  LinkMass payload = mass_value(value);
  payload.centre_mm = robot.X_flange * payload.centre_mm;
  robot.masses.back() = together(robot.masses.back(), payload);
}

}  // namespace truepose::config
