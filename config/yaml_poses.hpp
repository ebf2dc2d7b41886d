#pragma once

#include <Eigen/Geometry>

#include "config/yaml_reader.hpp"

namespace truepose::config {

/// {x, y, z, a, b, c}: mm and KUKA's angles in deg. All six must be there.
Eigen::Isometry3d pose_value(const YamlValue& value);

/// {x, y, z}: mm, within 10 m.
Eigen::Vector3d point_value(const YamlValue& value);

/// {x, y, z} of any length but zero, as a unit vector.
Eigen::Vector3d direction_value(const YamlValue& value);

}  // namespace truepose::config
