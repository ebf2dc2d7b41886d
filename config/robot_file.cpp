#include "config/robot_file.hpp"

#include "config/joint_list.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_reader.hpp"
#include "core/kinematics/angles.hpp"

namespace truepose::config {

namespace {

constexpr Range kMm{-100'000, 100'000};
constexpr Range kDeg{-360, 360};
constexpr Range kAxisDeg{-100'000, 100'000};  // an axis may turn without end
constexpr Range kSpeed{0, 100'000};

Joint joint(const YamlValue& value) {
  const YamlMap map(value, {"type", "a", "alpha", "d", "theta", "beta", "sign", "min", "max", "speed"});
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

  const double per_unit = joint.type == JointType::Revolute ? kRadPerDeg : 1.0;
  joint.min = map.at("min").number(kAxisDeg) * per_unit;
  joint.max = map.at("max").number(kAxisDeg) * per_unit;
  if (joint.min >= joint.max) map.at("min").fail("expected less than max");
  joint.speed = map.at("speed").number(kSpeed) * per_unit;
  if (joint.speed == 0) map.at("speed").fail("expected more than 0");
  return joint;
}

}  // namespace

RobotModel load_robot(const std::filesystem::path& file) {
  const YamlValue root = read_yaml(file);
  const YamlMap map(root, {"name", "joints", "flange"});
  RobotModel robot;
  robot.name = map.at("name").text();
  robot.joints = joints_value(map.at("joints"), joint);
  if (const YamlValue* flange = map.find("flange")) robot.X_flange = pose_value(*flange);
  return robot;
}

}  // namespace truepose::config
