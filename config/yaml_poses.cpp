#include "config/yaml_poses.hpp"

#include "config/ranges.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {

Eigen::Vector3d xyz_value(const YamlMap& map, Range range) {
  return {map.at("x").number(range), map.at("y").number(range), map.at("z").number(range)};
}

Eigen::Isometry3d pose_value(const YamlValue& value) {
  const YamlMap map(value, {"x", "y", "z", "a", "b", "c"});
  return pose_from_kuka(xyz_value(map, kMm),
                        {map.at("a").number(kDeg), map.at("b").number(kDeg), map.at("c").number(kDeg)});
}

Eigen::Matrix3d orientation_value(const YamlValue& value) {
  const YamlMap map(value, {"a", "b", "c"});
  return pose_from_kuka(Eigen::Vector3d::Zero(),
                        {map.at("a").number(kDeg), map.at("b").number(kDeg), map.at("c").number(kDeg)})
      .linear();
}

Eigen::Vector3d point_value(const YamlValue& value) {
  return xyz_value(YamlMap(value, {"x", "y", "z"}), {-10'000, 10'000});
}

Eigen::Vector3d direction_value(const YamlValue& value) {
  const Eigen::Vector3d direction = xyz_value(YamlMap(value, {"x", "y", "z"}), {-1000, 1000});
  if (direction.norm() < 1e-6) value.fail("a direction of no length");
  return direction.normalized();
}

std::vector<Capsule> capsules_value(const YamlValue& value) {
  std::vector<Capsule> capsules;
  for (const YamlValue& each : value.list()) {
    const YamlMap map(each, {"from", "to", "radius"});
    Capsule capsule;
    capsule.from_mm = capsule.to_mm = point_value(map.at("from"));
    if (const YamlValue* to = map.find("to")) capsule.to_mm = point_value(*to);
    capsule.radius_mm = map.at("radius").number({0, 10'000});
    capsules.push_back(capsule);
  }
  return capsules;
}

Box box_value(const YamlValue& value) {
  const YamlMap map(value, {"min", "max"});
  Box box;
  if (const YamlValue* min = map.find("min")) box.min_mm = point_value(*min);
  if (const YamlValue* max = map.find("max")) box.max_mm = point_value(*max);
  if ((box.min_mm.array() >= box.max_mm.array()).any()) value.fail("expected every min below its max");
  return box;
}

LinkMass mass_value(const YamlValue& value) {
  const YamlMap map(value, {"kg", "x", "y", "z"});
  return {.mass_kg = map.at("kg").number(kKg), .centre_mm = xyz_value(map, kMm)};
}

}  // namespace truepose::config
