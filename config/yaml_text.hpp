#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace truepose::config {

/// A text in double quotes with JSON's escapes, which YAML reads too: any text comes back as it was.
std::string quoted_text(std::string_view text);

/// "x: 1, y: 2, z: 3", every number with the digits that bring it back exactly.
std::string xyz_text(const Eigen::Vector3d& v);

}  // namespace truepose::config
