#include "core/arm/payload.hpp"

#include <algorithm>

namespace truepose {

std::expected<RobotModel, std::string> carrying(RobotModel robot, const LinkMass& payload) {
  if (!std::ranges::count(robot.deviation, DeviationBasis::Gravity, &DeviationTerm::basis)) {
    return std::unexpected(
        "the model has no gravity compliance for a payload: calibrate with --non-geometric auto. It needs the masses of "
        "the links in the robot file, or poses under two payloads (columns payload_kg, payload_x, payload_y and "
        "payload_z)");
  }
  if (!robot.masses.empty() && !robot.payload) {
    return std::unexpected(
        "the model does not say what the arm carried when it was measured: give the robot file its payload (kg: 0 for "
        "none) and calibrate again");
  }
  robot.payload = payload;
  return robot;
}

}  // namespace truepose
