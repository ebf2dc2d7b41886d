#include "tools/report/report_setup.hpp"

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>

#include "core/arm/joint_units.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/math/angles.hpp"
#include "tools/report/json_node.hpp"

namespace truepose::report {
namespace {

Eigen::Vector3d xyz(const Node& node) {
  return {node.find("x").number(), node.find("y").number(), node.find("z").number()};
}

Joint joint(const Node& node) {
  Joint joint;
  if (node.find("type").text() == "prismatic") joint.type = JointType::Prismatic;
  const double per_unit = unit_of(joint);
  joint.a_mm = node.find("a").number();
  joint.alpha_rad = node.find("alpha").number() * kRadPerDeg;
  joint.d_mm = node.find("d").number();
  joint.theta_rad = node.find("theta").number() * kRadPerDeg;
  joint.beta_rad = node.find("beta").number() * kRadPerDeg;
  joint.sign = node.find("sign").number();
  joint.min = node.find("min").number() * per_unit;
  joint.max = node.find("max").number() * per_unit;
  return joint;
}

/// Of record::arm_document(), as far as reports need it.
RobotModel arm(const Node& node) {
  RobotModel robot;
  robot.name = node.find("name").text();
  const std::vector<Node> joints = node.find("joints").elements();
  if (joints.size() > static_cast<std::size_t>(kMaxJoints)) node.find("joints").fail("a list that short");
  for (const Node& element : joints) {
    robot.joints.push_back(joint(element));
    const Node mass = element.find("mass");
    if (mass.exists()) robot.masses.push_back({mass.find("kg").number(), xyz(mass)});
  }
  return robot;
}

Eigen::Isometry3d base(const Node& node) {
  const BasePose pose{xyz(node),
                      {node.find("rx").number(), node.find("ry").number(), node.find("rz").number()}};
  return pose.isometry();
}

std::optional<Range> range(const Node& node) {
  if (!node.exists()) return std::nullopt;
  return Range{node.find("min").number(), node.find("max").number()};
}

Conditions conditions(const Node& node) {
  return {.started = node.find("started").text(),
          .ended = node.find("ended").text(),
          .poses_measured = node.find("poses_measured").count(),
          .poses_skipped = node.find("poses_skipped").count(),
          .temperature_c = range(node.find("temperature_c")),
          .pressure_mbar = range(node.find("pressure_mbar")),
          .humidity_percent = range(node.find("humidity_percent"))};
}

std::vector<std::pair<std::string, std::string>> texts(const Node& node) {
  std::vector<std::pair<std::string, std::string>> result;
  if (!node.exists()) return result;
  for (const auto& member : node.object()) {
    const std::string key = member.key();
    result.emplace_back(key, node.find(key).text());
  }
  return result;
}

}  // namespace

Setup read_setup(const boost::json::object& document) {
  const auto member = [&](const char* key) { return Node{document.if_contains(key), key}; };
  Setup setup;
  if (const Node node = member("arm"); node.exists()) setup.arm = arm(node);
  if (const Node node = member("base"); node.exists()) setup.X_WB = base(node);
  if (const Node node = member("conditions"); node.exists()) setup.conditions = conditions(node);
  if (const Node node = member("skipped"); node.exists()) {
    for (const Node& pose : node.elements()) {
      setup.skipped.push_back(
          {pose.find("pose").count(), pose.find("attempts").count(), pose.find("reason").text()});
    }
  }
  if (const Node node = member("reference_drift_mm"); node.exists()) {
    setup.reference_drift_mm = node.numbers();
  }
  setup.options = texts(member("options"));
  setup.files = texts(member("files"));
  return setup;
}

std::string time_text(const std::string& rfc3339) {
  const bool known = rfc3339.size() >= 20 && rfc3339[10] == 'T' && rfc3339.back() == 'Z';
  return known ? rfc3339.substr(0, 10) + " " + rfc3339.substr(11, 5) + " UTC" : rfc3339;
}

}  // namespace truepose::report
