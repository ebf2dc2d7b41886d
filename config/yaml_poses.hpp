#pragma once

#include <Eigen/Geometry>

#include "config/yaml_reader.hpp"
#include "core/arm/robot_model.hpp"
#include "core/plan/scene.hpp"

namespace truepose::config {

/// {x, y, z, a, b, c}: mm and KUKA's angles in deg. All six must be there.
Eigen::Isometry3d pose_value(const YamlValue& value);

/// {a, b, c}: KUKA's angles in deg.
Eigen::Matrix3d orientation_value(const YamlValue& value);

/// x, y and z of a map that may hold other keys too.
Eigen::Vector3d xyz_value(const YamlMap& map, Range range);

/// {x, y, z}: mm, within 10 m.
Eigen::Vector3d point_value(const YamlValue& value);

/// {x, y, z} of any length but zero, as a unit vector.
Eigen::Vector3d direction_value(const YamlValue& value);

/// A list of {from: {x, y, z}, to: {x, y, z}, radius}: mm. Without `to` a sphere.
std::vector<Capsule> capsules_value(const YamlValue& value);

/// {min: {x, y, z}, max: {x, y, z}}: mm. Either corner may be left out: no bound.
Box box_value(const YamlValue& value);

/// {kg, x, y, z}: a mass and its centre, mm.
LinkMass mass_value(const YamlValue& value);

}  // namespace truepose::config
