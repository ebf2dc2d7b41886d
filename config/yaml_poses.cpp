#include "config/yaml_poses.hpp"

#include "core/kinematics/angles.hpp"

namespace truepose::config {

namespace {

constexpr Range kMm{-100'000, 100'000};
constexpr Range kDeg{-360, 360};

Eigen::Vector3d xyz(const YamlMap& map, Range range) {
  return {map.at("x").number(range), map.at("y").number(range), map.at("z").number(range)};
}

}  // namespace

Eigen::Isometry3d pose_value(const YamlValue& value) {
  const YamlMap map(value, {"x", "y", "z", "a", "b", "c"});
  return pose_from_kuka(xyz(map, kMm),
                        {map.at("a").number(kDeg), map.at("b").number(kDeg), map.at("c").number(kDeg)});
}

Eigen::Vector3d point_value(const YamlValue& value) {
  return xyz(YamlMap(value, {"x", "y", "z"}), {-10'000, 10'000});
}

Eigen::Vector3d direction_value(const YamlValue& value) {
  const Eigen::Vector3d direction = xyz(YamlMap(value, {"x", "y", "z"}), {-1000, 1000});
  if (direction.norm() < 1e-6) value.fail("a direction of no length");
  return direction.normalized();
}

}  // namespace truepose::config
