#include "config/robot_file.hpp"

#include "config/joint_list.hpp"
#include "config/ranges.hpp"
#include "config/robot_payload.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_reader.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {

namespace {

constexpr Range kAxisDeg{-100'000, 100'000};  // an axis may turn without end
constexpr Range kSpeed{0, 100'000};

YamlMap joint_map(const YamlValue& joint) {
  return {joint,
          {"type", "a", "alpha", "d", "theta", "beta", "sign", "min", "max", "speed", "acceleration", "mass",
           "body"}};
}

Joint joint(const YamlValue& value) {
  const YamlMap map = joint_map(value);
  Joint joint;
  map.read("type", joint.type, {{"revolute", JointType::Revolute}, {"prismatic", JointType::Prismatic}});
  joint.a_mm = map.at("a").number(kMm);
  joint.alpha_rad = map.at("alpha").number(kDeg) * kRadPerDeg;
  joint.d_mm = map.at("d").number(kMm);
  joint.theta_rad = map.at("theta").number(kDeg) * kRadPerDeg;
  double beta_deg = 0;
  map.read("beta", beta_deg, kDeg);
  joint.beta_rad = beta_deg * kRadPerDeg;

  joint.sign = static_cast<double>(map.at("sign").integer(-1, 1));
  if (joint.sign == 0) map.at("sign").fail("expected -1 or 1, found 0");

  const double per_unit = unit_of(joint);
  joint.min = map.at("min").number(kAxisDeg) * per_unit;
  joint.max = map.at("max").number(kAxisDeg) * per_unit;
  if (joint.min >= joint.max) map.at("min").fail("expected less than max");
  joint.speed = map.at("speed").number(kSpeed) * per_unit;
  if (joint.speed == 0) map.at("speed").fail("expected more than 0");
  map.read("acceleration", joint.acceleration, kSpeed);
  joint.acceleration *= per_unit;
  return joint;
}

/// One per joint, or none at all.
std::vector<LinkMass> masses_value(const YamlValue& joints) {
  std::vector<LinkMass> masses;
  const YamlValue* without = nullptr;
  for (const YamlValue& joint : joints.list()) {
    if (const YamlValue* mass = joint_map(joint).find("mass")) {
      masses.push_back(mass_value(*mass));
    } else if (!without) {
      without = &joint;
    }
  }
  if (without && !masses.empty()) without->fail("missing key 'mass': give one to every joint or to none");
  return masses;
}

YamlMap robot_map(const YamlValue& root) {
  return {root, {"name", "joints", "flange", "payload", "gravity", "base_body"}};
}

void add_parts(std::vector<BodyPart>& body, int link, const YamlValue* capsules) {
  if (!capsules) return;
  for (const Capsule& capsule : capsules_value(*capsules)) body.push_back({link, capsule});
}

}  // namespace

RobotModel load_robot(const std::filesystem::path& file) {
  const YamlValue root = read_yaml(file);
  const YamlMap map = robot_map(root);
  RobotModel robot;
  robot.name = map.at("name").text();
  robot.joints = joints_value(map.at("joints"), joint);
  if (const YamlValue* flange = map.find("flange")) robot.X_flange = pose_value(*flange);
  robot.masses = masses_value(map.at("joints"));
  if (const YamlValue* payload = map.find("payload")) add_payload(robot, *payload);
  if (const YamlValue* gravity = map.find("gravity")) robot.gravity_B = direction_value(*gravity);
  return robot;
}

std::vector<BodyPart> load_body(const std::filesystem::path& file) {
  const YamlValue root = read_yaml(file);
  const YamlMap map = robot_map(root);
  std::vector<BodyPart> body;
  add_parts(body, 0, map.find("base_body"));
  int link = 0;
  for (const YamlValue& joint : map.at("joints").list())
    add_parts(body, ++link, joint_map(joint).find("body"));
  return body;
}

}  // namespace truepose::config
